#pragma once

// How a camera's colours differ from the scene's: exposure; gain, offset, gamma and crosstalk of its channels; corners
// that get less light; and noise. Each camera has its own, drawn from its seed, as different as two Kinects are whose
// automatic exposure and white balance see different parts of a room.
//
// Thread: a value; functions that change nothing may be called from any thread.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"

namespace copresence::simulation {

/// A pixel before noise, times 16; no channel is cut off at 0 or 255.
struct SensedColor {
  std::int16_t r = 0, g = 0, b = 0;
  friend bool operator==(const SensedColor&, const SensedColor&) = default;
};
static_assert(sizeof(SensedColor) == 6);
using SensedColors = Image<SensedColor>;

class ColorResponse {
 public:
  /// Camera 0 is nearly true; the others take 35 to 65 % of its light and differ by up to 12 % in gain, 5 of 255 in offset
  /// and 8 % in gamma.
  ColorResponse(int width, int height, std::uint32_t seed, std::uint32_t camera);

  /// What the camera has of a true picture before noise. Requires the size given.
  void sense(const ColorImage& truth, SensedColors& sensed) const;

  /// The camera's picture of that, row by row. Requires the size given of both.
  void expose(const SensedColors& sensed, std::uint64_t frame, std::span<Rgb8> picture) const;

  /// Without noise and vignetting, channels 0 to 1 in and out: what colour matching is to undo.
  Eigen::Vector3f respond(const Eigen::Vector3f& color) const;

 private:
  std::uint32_t seed_;
  Eigen::Matrix3f mixing_;
  Eigen::Vector3f offset_, gamma_;
  std::vector<std::uint16_t> corner_;                   // per pixel: what remains of the light, times 4096
  std::array<std::array<std::int16_t, 3>, 256> curve_;  // per true value and channel: gamma, times 16
  std::array<std::int32_t, 9> mixing_fixed_{};          // times 4096
  std::array<std::int32_t, 3> offset_fixed_{};          // times 16
  std::vector<std::int8_t> grain_;                      // a tile of noise, times 16
};

}  // namespace copresence::simulation
