#pragma once

// What a figure's parts look like where a camera sees them: from hits to places, patterns and light.
//
// Thread: free functions; a value.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "simulation/figure_hits.h"
#include "simulation/light.h"
#include "simulation/mesh.h"
#include "simulation/sight.h"

namespace copresence::simulation {

/// Of some hits of one part, hit by hit.
struct PartSurface {
  MovingPoints points;        ///< in the world, with the normal on the camera's side
  std::vector<float> facing;  ///< cosine between the surface and the way to the camera, 0 to 1
};

void find_surface(const Mesh& part, const Eigen::Isometry3f& world_from_part, const Sight& sight,
                  std::span<const Hit> hits, PartSurface& surface);

/// The pattern's coordinates of each pixel of a picture, valid where a part is seen.
using PatternImage = std::vector<Eigen::Vector2f>;

/// Enters those of a part's hits.
void find_pattern(const Mesh& part, std::span<const Hit> hits, PatternImage& pattern);

/// Where in a part's pattern kFigureLooks fall in each of some pixels: `u` and `v` get the first look of all hits, then the
/// second, and so on. A pixel sees an area, whose size its neighbours tell.
void spread_looks(const FigureHits& all, std::span<const Hit> hits, const PatternImage& pattern,
                  std::vector<float>& u, std::vector<float>& v);

}  // namespace copresence::simulation
