#pragma once

// The figure as one camera sees it at one instant, drawn over the room.
//
// Thread: one thread per object; several may share a world.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "simulation/figure_hits.h"
#include "simulation/figure_raster.h"
#include "simulation/figure_rays.h"
#include "simulation/figure_surface.h"
#include "simulation/room_view.h"
#include "simulation/sight.h"
#include "simulation/true_view.h"
#include "simulation/world.h"

namespace copresence::simulation {

class FigureView {
 public:
  FigureView(std::shared_ptr<const World> world, const Sight& sight);

  /// Puts the room back into `view` wherever draw() has put the figure.
  void erase(const RoomView& room, TrueView& view);

  enum class How {
    kByRays,      ///< exact
    kByTriangles  ///< quicker and the same but for rounding, see FigureRaster; by rays where that cannot
  };

  /// Draws it where the room is not nearer. `pose`: world from each part; `capsules`: the parts in the world, for their shadows on each
  /// other. Requires an erased view, and the sight that the object was made with.
  void draw(const Sight& sight, const RoomView& room, std::span<const Eigen::Isometry3f> pose,
            std::span<const Capsule> capsules, How how, TrueView& view);

 private:
  void draw_some(std::size_t part, const Eigen::Isometry3f& world_from_part, std::span<const Hit> hits,
                 const Sight& sight, std::span<const Capsule> capsules, TrueView& view);
  void smooth_outline(const RoomView& room, TrueView& view) const;

  std::shared_ptr<const World> world_;
  FigureRays rays_;
  FigureRaster raster_;
  FigureHits hits_;
  PatternImage pattern_;
  std::vector<Eigen::Vector3f> light_;  // per pixel, valid where a part is seen

  // Of the hits that are being drawn.
  PartSurface surface_;
  MovingLight surface_light_;                      // before shadows
  std::vector<float> hidden_;                      // share of the first lamp that is shaded
  std::vector<float> look_u_, look_v_;             // see spread_looks()
  std::array<std::vector<float>, 3> look_colors_;  // likewise; the first become light
  std::vector<Rgb8> screen_;
};

}  // namespace copresence::simulation
