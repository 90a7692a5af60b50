#pragma once

// The still part of a world as one camera sees it, traced once, and the figure's shadow on it.
//
// Thread: one thread per object; several may share a world.

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "simulation/sight.h"
#include "simulation/true_view.h"
#include "simulation/world.h"

namespace copresence::simulation {

/// Of the lamp's disc, metres: how soft shadows are.
inline constexpr float kLampRadius = 0.2f;

class RoomView {
 public:
  /// Traces everything that never moves. Keeps neither argument but the world.
  RoomView(std::shared_ptr<const World> world, const Sight& sight);

  const TrueView& still() const { return still_; }

  /// With the shadow that was cast last.
  const ColorImage& color() const { return color_; }
  const Eigen::Vector3f& light(std::size_t pixel) const { return light_[pixel]; }

  /// Casts the shadow of the figure's parts, world frame, instead of the one before. `seen`: a picture whose pixels change along
  /// with color().
  void cast_shadows(std::span<const Capsule> capsules, ColorImage& seen);

 private:
  struct Block {
    int x = 0, y = 0;  // top left pixel of four that share one shadow value
  };

  void trace(const Sight& sight);
  void find_shadow_blocks(const Sight& sight);
  std::size_t add_light(std::span<const Ray> rays, float share, std::size_t pixel);
  Light light_along(const Ray& ray, const Eigen::Vector3f& color, bool mirrors) const;

  std::shared_ptr<const World> world_;
  TrueView still_;
  std::vector<Eigen::Vector3f> still_light_, still_lamp_;  // linear; the lamp's part of it
  std::vector<Block> blocks_;
  ShadowPoints shadow_points_;
  std::vector<float> hidden_;
  std::vector<Eigen::Vector3f> light_;             // per pixel: the still light with the figure's shadow
  ColorImage color_;                               // the same as seen
  std::vector<float> u_, v_, red_, green_, blue_;  // of neighbouring rays, see add_light()
};

}  // namespace copresence::simulation
