#pragma once

// How a camera's colours differ from the scene's: exposure; gain, offset, gamma and crosstalk of its channels; corners
// that get less light; and noise. Each camera has its own, drawn from its seed, as different as two Kinects are whose
// automatic exposure and white balance see different parts of a room.
//
// Thread: one thread per object.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"

namespace copresence::simulation {

class ColorResponse {
 public:
  /// Camera 0 is nearly true; the others take 35 to 65 % of its light and differ by up to 12 % in gain, 5 of 255 in offset
  /// and 8 % in gamma.
  ColorResponse(int width, int height, std::uint32_t seed, std::uint32_t camera);

  /// The camera's picture of a true one. What did not change since the last exposure is not computed again.
  /// Requires the size given.
  /// What did not change since the last exposure is not computed again.
  void expose(const ColorImage& truth, std::uint64_t frame, ColorImage& picture);

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
  ColorImage truth_;                                    // of the last exposure
  std::vector<std::int16_t> clean_;                     // what the camera makes of it but for noise, times 16
};

}  // namespace copresence::simulation
