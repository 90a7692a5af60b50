#pragma once

// Fits a colour correction to pairs of colours, many of which may be wrong. RANSAC finds gain and
// offset of each channel (Fischler and Bolles 1981). Least squares over the pairs that agree then
// finds all twelve numbers (thesis 2.6.2). Thread: pure functions.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace copresence::color_matching {

/// The linear map from the colours of one camera to those of another (thesis 2.6.2). The mapped
/// colour is correction * (r, g, b, 1), with channels from 0 to 1.
using ColorCorrection = Eigen::Matrix<float, 3, 4>;

inline Eigen::Vector3f apply(const ColorCorrection& correction, const Eigen::Vector3f& color) {
  return correction.leftCols<3>() * color + correction.col(3);
}

/// Returns the correction that applies `second` and then `first`.
inline ColorCorrection chain(const ColorCorrection& first, const ColorCorrection& second) {
  ColorCorrection result;
  result.leftCols<3>() = first.leftCols<3>() * second.leftCols<3>();
  result.col(3) = apply(first, second.col(3));
  return result;
}

/// The colour of one point of a surface in the images of two cameras, channels 0 to 1.
struct ColorPair {
  Eigen::Vector3f from, to;
};

/// A fit needs at least this many pairs.
inline constexpr std::size_t kFewestPairs = 60;

struct ColorFit {
  ColorCorrection correction;
  std::vector<ColorPair> inliers;  ///< At most kMostInliers pairs that agree with the fit.
  std::size_t agreeing = 0;        ///< Number of all pairs that agree with the fit.
  double rms = 0;                  ///< RMS error of their channels, 0 to 1.
};
inline constexpr std::size_t kMostInliers = 1500;

/// Returns nothing for fewer than kFewestPairs pairs, or if less than a third of them agree on one
/// correction with gains between 0.4 and 2.5.
std::optional<ColorFit> fit_color_correction(std::span<const ColorPair> pairs);

/// Fits all twelve numbers by least squares, regularised towards `near`. So `near` decides for
/// colours that the scene does not contain. Requires at least one pair.
ColorCorrection refine_color_correction(std::span<const ColorPair> pairs, const ColorCorrection& near);

}  // namespace copresence::color_matching
