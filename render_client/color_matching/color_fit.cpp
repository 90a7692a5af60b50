#include "render_client/color_matching/color_fit.h"

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>
#include <cstdint>

namespace copresence::color_matching {
namespace {

constexpr int kGuesses = 400;
constexpr std::size_t kMostTested = 1000;  // Each guess is tested on at most this many pairs.
// A pair agrees with a correction if its error is at most this. The coarse limit is for corrections
// that have gains and offsets only. The fine limit allows for noise, vignetting and gamma.
constexpr float kCoarse = 18.0F / 255;
constexpr float kFine = 9.0F / 255;
constexpr float kLeastGain = 0.4F, kMostGain = 2.5F, kMostOffset = 0.25F;
// Two pairs determine the gain of a channel only if their values differ by at least this.
constexpr float kApart = 0.12F;
constexpr double kHold = 3e-4;  // Weight of `near`, relative to the number of pairs.

// A random generator that gives the same numbers, and thus the same correction, on every machine.
class RandomGenerator {
 public:
  std::size_t below(std::size_t bound) {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>((state_ >> 33) % bound);
  }

 private:
  std::uint64_t state_ = 0x9E3779B97F4A7C15U;
};

float error(const ColorCorrection& correction, const ColorPair& pair) {
  return (apply(correction, pair.from) - pair.to).cwiseAbs().maxCoeff();
}

// Computes gain and offset of each channel from two pairs. A channel in which the pairs hardly
// differ gets a gain and no offset.
std::optional<ColorCorrection> guess(const ColorPair& a, const ColorPair& b) {
  ColorCorrection correction = ColorCorrection::Zero();
  for (int c = 0; c < 3; ++c) {
    const float apart = a.from[c] - b.from[c];
    const float gain = std::abs(apart) >= kApart ? (a.to[c] - b.to[c]) / apart
                                                 : (a.to[c] + b.to[c]) / (a.from[c] + b.from[c]);
    const float offset = 0.5F * (a.to[c] + b.to[c] - gain * (a.from[c] + b.from[c]));
    if (!(gain >= kLeastGain && gain <= kMostGain && std::abs(offset) <= kMostOffset)) return std::nullopt;
    correction(c, c) = gain;
    correction(c, 3) = offset;
  }
  return correction;
}

std::vector<ColorPair> agreeing(std::span<const ColorPair> pairs, const ColorCorrection& correction,
                                float tolerance) {
  std::vector<ColorPair> result;
  for (const ColorPair& pair : pairs) {
    if (error(correction, pair) <= tolerance) result.push_back(pair);
  }
  return result;
}

std::vector<ColorPair> spread(const std::vector<ColorPair>& pairs, std::size_t most) {
  if (pairs.size() <= most) return pairs;
  std::vector<ColorPair> result;
  for (std::size_t i = 0; i < most; ++i) result.push_back(pairs[i * pairs.size() / most]);
  return result;
}

}  // namespace

ColorCorrection refine_color_correction(std::span<const ColorPair> pairs, const ColorCorrection& near) {
  assert(!pairs.empty());
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
  for (const ColorPair& pair : pairs) {
    const Eigen::Vector4d from(pair.from.x(), pair.from.y(), pair.from.z(), 1);
    normal += from * from.transpose();
    right += from * pair.to.cast<double>().transpose();
  }
  const double hold = kHold * static_cast<double>(pairs.size());
  normal.diagonal().array() += hold;
  right += hold * near.cast<double>().transpose();
  return normal.ldlt().solve(right).transpose().cast<float>();
}

std::optional<ColorFit> fit_color_correction(std::span<const ColorPair> pairs) {
  if (pairs.size() < kFewestPairs) return std::nullopt;
  RandomGenerator random;
  std::vector<ColorPair> tested;
  for (std::size_t i = 0; i < std::min(pairs.size(), kMostTested); ++i) {
    tested.push_back(pairs.size() <= kMostTested ? pairs[i] : pairs[random.below(pairs.size())]);
  }
  ColorCorrection best;
  std::size_t most = 0;
  for (int i = 0; i < kGuesses; ++i) {
    const auto correction = guess(tested[random.below(tested.size())], tested[random.below(tested.size())]);
    if (!correction) continue;
    std::size_t count = 0;
    for (const ColorPair& pair : tested) count += error(*correction, pair) <= kCoarse;
    if (count > most) {
      most = count;
      best = *correction;
    }
  }
  if (3 * most < tested.size()) return std::nullopt;

  ColorCorrection correction = refine_color_correction(agreeing(pairs, best, kCoarse), best);
  for (int round = 0; round < 2; ++round) {
    const auto inliers = agreeing(pairs, correction, kFine);
    if (inliers.size() < kFewestPairs || 3 * inliers.size() < pairs.size()) return std::nullopt;
    correction = refine_color_correction(inliers, best);
  }
  const auto inliers = agreeing(pairs, correction, kFine);
  ColorFit fit{correction, spread(inliers, kMostInliers), inliers.size(), 0};
  double squares = 0;
  for (const ColorPair& pair : inliers) squares += (apply(correction, pair.from) - pair.to).squaredNorm();
  fit.rms = std::sqrt(squares / (3.0 * std::max<double>(1, static_cast<double>(inliers.size()))));
  return fit;
}

}  // namespace copresence::color_matching
