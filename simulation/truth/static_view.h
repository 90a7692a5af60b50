#pragma once

// Private to TrueCamera: the static part of a scene as one camera sees it, traced once, and the
// shadow of the figure on it.
// Thread: one thread at a time per object; several objects may share a scene.

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "simulation/truth/lit_scene.h"
#include "simulation/truth/ray_tracer.h"
#include "simulation/truth/shadow.h"
#include "simulation/truth/true_camera.h"

namespace copresence::simulation {

class StaticView {
 public:
  /// Traces all static surfaces. The rays are needed only in the constructor.
  StaticView(std::shared_ptr<const LitScene> scene, const PixelRays& rays);

  /// Returns the view without figure and shadow.
  const TrueView& view() const { return view_; }

  /// Colour and light with the shadow of the last cast_figure_shadow().
  const ColorImage& color() const { return color_; }
  const Eigen::Vector3f& light(std::size_t pixel) const { return light_[pixel]; }

  /// Replaces the shadow of the figure by the shadow of `capsules` (world frame). Changed pixels
  /// are also written to `view`.
  void cast_figure_shadow(std::span<const Capsule> capsules, ColorImage& view);

 private:
  struct Block {
    int x = 0, y = 0;  // Top left pixel of the block.
  };

  void trace(const PixelRays& pixels);
  void find_shadow_blocks(const PixelRays& pixels);
  std::size_t add_light(std::span<const Ray> rays, float share, std::size_t pixel);
  Light reflected_light(const Ray& ray, const Eigen::Vector3f& color, bool mirrors) const;

  std::shared_ptr<const LitScene> scene_;
  TrueView view_;
  // Linear light per pixel without the figure's shadow, and the part of it that the lamp gives.
  std::vector<Eigen::Vector3f> static_light_, static_lamp_;
  std::vector<Block> blocks_;
  ShadowPoints shadow_points_;
  std::vector<float> hidden_;                      // Per block: the hidden share of the lamp.
  std::vector<Eigen::Vector3f> light_;             // Light per pixel with the shadow of the figure.
  ColorImage color_;                               // The light after tone mapping.
  std::vector<float> u_, v_, red_, green_, blue_;  // Buffers of add_light().
};

}  // namespace copresence::simulation
