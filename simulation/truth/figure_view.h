#pragma once

// Private to TrueCamera: the figure as a camera sees it at one instant, drawn over the static view.
// Thread: one thread at a time per object; several objects may share a scene.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "simulation/truth/figure_tracing.h"
#include "simulation/truth/lit_scene.h"
#include "simulation/truth/ray_tracer.h"
#include "simulation/truth/shadow.h"
#include "simulation/truth/static_view.h"
#include "simulation/truth/true_camera.h"

namespace copresence::simulation {

class FigureView {
 public:
  FigureView(std::shared_ptr<const LitScene> scene, const PixelRays& pixels);

  /// Restores the static view where the last draw() put the figure.
  void erase(const StaticView& background, TrueView& view);

  /// Draws the figure where it is nearer than the static scene. `pose` holds world_from_part for
  /// each part. `capsules` are the parts in the world frame; they cast shadows on each other.
  /// Requires an erased view and the rays given to the constructor.
  void draw(const PixelRays& pixels, const StaticView& background, std::span<const Eigen::Isometry3f> pose,
            std::span<const Capsule> capsules, TrueView& view);

 private:
  /// Surface points of the hits that are being drawn, in the world frame, one array per coordinate.
  struct Points {
    ShadowPoints positions;
    std::vector<float> normal_x, normal_y, normal_z;  // Unit length, towards the camera.
    std::vector<float> cosine;  // Cosine of the angle between normal and view ray, 0 to 1.
  };
  /// Light at these points without shadows, per channel. See Light for its two parts.
  struct PointLight {
    std::array<std::vector<float>, 3> lamp, rest;
  };

  void draw_hits(std::size_t part, const Eigen::Isometry3f& world_from_part, std::span<const Hit> hits,
                 const PixelRays& pixels, std::span<const Capsule> capsules, TrueView& view);
  void find_points(const Mesh& part, const Eigen::Isometry3f& world_from_part, const PixelRays& pixels,
                   std::span<const Hit> hits);
  void light_points();
  void find_samples(std::span<const Hit> hits);
  Eigen::Vector2f uv_change(std::size_t pixel, std::size_t distance) const;
  void smooth_silhouette(const StaticView& background, TrueView& view) const;

  std::shared_ptr<const LitScene> scene_;
  FigureTracer tracer_;
  FigureHits hits_;
  std::vector<Eigen::Vector2f> uv_;     // Per pixel: texture coordinates, valid where the figure is visible.
  std::vector<Eigen::Vector3f> light_;  // Per pixel: reflected light, valid in the same places.

  // The following members are buffers for the hits that are being drawn.
  Points points_;
  PointLight point_light_;
  std::vector<float> hidden_;  // Share of the lamp that is in shadow.
  // First samples of all hits, followed by all second samples and so on.
  std::vector<float> sample_u_, sample_v_;
  // Colours of the samples, in the same order as their texture coordinates. The first sample of
  // each hit becomes its light.
  std::array<std::vector<float>, 3> sample_colors_;
  std::vector<Rgb8> screen_;
};

}  // namespace copresence::simulation
