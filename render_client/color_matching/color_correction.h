#pragma once

// Colours of one camera to another's (thesis 2.6.2): channels 0 to 1, to = map * (r, g, b, 1). Thread: values.

#include <Eigen/Core>

namespace copresence::color_matching {

using ColorCorrection = Eigen::Matrix<float, 3, 4>;

inline Eigen::Vector3f apply(const ColorCorrection& map, const Eigen::Vector3f& color) {
  return map.leftCols<3>() * color + map.col(3);
}

/// First `second`, then `first`.
inline ColorCorrection chain(const ColorCorrection& first, const ColorCorrection& second) {
  ColorCorrection result;
  result.leftCols<3>() = first.leftCols<3>() * second.leftCols<3>();
  result.col(3) = apply(first, second.col(3));
  return result;
}

/// The colour of one place as two cameras see it, channels 0 to 1.
struct ColorPair {
  Eigen::Vector3f from, to;
};

}  // namespace copresence::color_matching
