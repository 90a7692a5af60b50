#pragma once

// Private to TrueCamera: finds by ray tracing which surface points of the figure a camera sees.
// Only cells of pixels that are covered by bounding spheres of the figure's parts are traced.
// Thread: one thread at a time per object; several objects may share a scene.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "simulation/truth/lit_scene.h"
#include "simulation/truth/ray_tracer.h"

namespace copresence::simulation {

/// Sample points of a pixel's colour, in pixels from its centre. No two share a sub-pixel row or
/// column.
inline const std::array<Eigen::Vector2f, 4> kFigureSamples{
    Eigen::Vector2f(-0.125f, -0.375f), Eigen::Vector2f(0.375f, -0.125f), Eigen::Vector2f(0.125f, 0.375f),
    Eigen::Vector2f(-0.375f, 0.125f)};

/// The surface point of a part at the centre of a pixel.
struct Hit {
  std::uint32_t pixel = 0, triangle = 0;
  float depth = 0;     ///< Depth along the optical axis, in metres.
  float u = 0, v = 0;  ///< Barycentric weights of the second and third vertex.
};

/// All pixels that show the figure.
struct FigureHits {
  using SampleParts = std::array<std::int32_t, kFigureSamples.size()>;

  FigureHits(std::size_t picture_width, std::size_t picture_height, std::size_t part_count);

  void clear();

  /// Computes `part_of`, `runs` and `silhouette` from the hits.
  void close();

  std::size_t width, height;
  std::vector<std::vector<Hit>> parts;  ///< Hits of each part.

  /// Consecutive pixels of a row.
  struct Run {
    std::size_t first = 0, count = 0;
  };
  std::vector<Run> runs;             ///< Per row: all pixels whose colour the figure may change.
  std::vector<std::int8_t> part_of;  ///< Per pixel: the part at its centre, or -1.
  /// Pixels with a neighbour that shows another part or the background.
  std::vector<std::uint32_t> silhouette;
  std::vector<SampleParts> sample_parts;  ///< Per silhouette pixel and sample: the part, or -1.
};

class FigureTracer {
 public:
  FigureTracer(std::shared_ptr<const LitScene> scene, const PixelRays& pixels);

  /// Finds the points of the figure that are nearer than `background`, the static scene's depth per
  /// pixel (0 for none). `pose` holds world_from_part for each part. Requires empty hits and the
  /// rays given to the constructor.
  void find(const PixelRays& pixels, const Image<float>& background, std::span<const Eigen::Isometry3f> pose,
            FigureHits& hits);

 private:
  struct Sphere {
    Eigen::Vector3f center;
    float radius = 0;
  };

  void bound_parts();
  void find_cells(const PixelRays& pixels, std::span<const Eigen::Isometry3f> pose);
  template <class Visit>
  void for_each_run(std::size_t width, Visit&& visit) const;

  std::shared_ptr<const LitScene> scene_;
  PosedScene posed_;
  std::vector<std::vector<Sphere>> bounds_;  // Spheres that contain each part, in its own frame.
  Image<std::uint8_t> cells_;                // The value is 1 for each cell that may show the figure.
  std::vector<Ray> rays_;
};

}  // namespace copresence::simulation
