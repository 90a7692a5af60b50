#pragma once

// The difference between a camera's colours and the scene's: exposure, gain, offset, gamma and
// crosstalk of the channels, vignetting, and noise. The parameters are random values from a seed.
// Cameras differ like two Kinects that see different parts of a room.
// Thread: const functions are safe on any thread.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"

namespace copresence::simulation {

/// A pixel before noise, in units of 1/16. Channels are not clamped to 0 to 255.
struct NoiseFreeColor {
  std::int16_t r = 0, g = 0, b = 0;
  friend bool operator==(const NoiseFreeColor&, const NoiseFreeColor&) = default;
};
static_assert(sizeof(NoiseFreeColor) == 6);
using NoiseFreeColors = Image<NoiseFreeColor>;

class ColorResponse {
 public:
  /// The colours of camera 0 are nearly true. The other cameras get 35 to 65 % of its light and
  /// differ by up to 12 % in gain, 5 of 255 in offset and 8 % in gamma. Sizes are in pixels.
  ColorResponse(int width, int height, std::uint32_t seed, std::uint32_t camera);

  /// Applies everything except noise. Requires images of the size given to the constructor.
  void apply_response(const ColorImage& truth, NoiseFreeColors& colors) const;

  /// Writes the picture of frame `frame` row by row. Both have the constructor's size.
  void add_noise(const NoiseFreeColors& colors, std::uint64_t frame, std::span<Rgb8> picture) const;

  /// Returns the response to one colour without noise and vignetting, with channels from 0 to 1.
  /// Colour correction has to invert this response.
  Eigen::Vector3f respond_to(const Eigen::Vector3f& color) const;

 private:
  std::uint32_t seed_;
  Eigen::Matrix3f mixing_;
  Eigen::Vector3f offset_, gamma_;
  std::vector<std::uint16_t> vignetting_;               // Vignetting per pixel, times 4096.
  std::array<std::array<std::int16_t, 3>, 256> curve_;  // Gamma curve as [true value][channel], times 16.
  std::array<std::int32_t, 9> mixing_fixed_{};          // Crosstalk, times 4096.
  std::array<std::int32_t, 3> offset_fixed_{};          // Offset, times 16.
  std::vector<std::int8_t> grain_;                      // A tile of noise values, times 16.
};

}  // namespace copresence::simulation
