#include "render_client/color_matching/color_matcher.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

namespace copresence::color_matching {
namespace {

constexpr int kSpacingPx = 6;
// Weight of the chained correction in the joint fit, relative to the number of pairs.
constexpr double kHold = 1e-3;
constexpr double kEaseSeconds = 2;  // Time constant of SteadyCorrections.

/// The overlap of two cameras. `fit` maps the colours of `from` to those of `to`.
struct Overlap {
  std::size_t from, to;
  ColorFit fit;
};

std::vector<Overlap> find_overlaps(std::span<const PosedFrame> frames) {
  const auto takes_part = [&](std::size_t i) { return frames[i].frame != nullptr && frames[i].frame->color; };
  std::vector<Overlap> overlaps;
  for (std::size_t to = 0; to < frames.size(); ++to) {
    for (std::size_t from = to + 1; from < frames.size(); ++from) {
      if (!takes_part(from) || !takes_part(to)) continue;
      if (auto fit = fit_color_correction(find_color_pairs(frames[from], frames[to], kSpacingPx))) {
        overlaps.push_back({from, to, std::move(*fit)});
      }
    }
  }
  // The best overlaps come first, since chains are made of them.
  std::sort(overlaps.begin(), overlaps.end(),
            [](const Overlap& a, const Overlap& b) { return a.fit.agreeing > b.fit.agreeing; });
  return overlaps;
}

ColorCorrection inverse(const Overlap& overlap) {
  std::vector<ColorPair> back;
  for (const ColorPair& pair : overlap.fit.inliers) back.push_back({pair.to, pair.from});
  const Eigen::Matrix3f linear = overlap.fit.correction.leftCols<3>();
  ColorCorrection guess;
  guess.leftCols<3>() = linear.inverse();
  guess.col(3) = -(guess.leftCols<3>() * overlap.fit.correction.col(3));
  return refine_color_correction(back, guess);
}

// Chains every camera to the reference along the best overlaps.
std::vector<std::optional<ColorCorrection>> chain_to_reference(const std::vector<Overlap>& overlaps,
                                                               std::size_t cameras) {
  std::vector<std::optional<ColorCorrection>> corrections(cameras);
  corrections[0] = ColorCorrection::Identity();
  for (bool grown = true; grown;) {
    grown = false;
    for (const Overlap& overlap : overlaps) {
      auto &from = corrections[overlap.from], &to = corrections[overlap.to];
      if (from.has_value() == to.has_value()) continue;
      if (to) {
        from = chain(*to, overlap.fit.correction);
      } else {
        to = chain(*from, inverse(overlap));
      }
      grown = true;
      break;  // The search starts again at the best overlap.
    }
  }
  return corrections;
}

// Fits all corrections together, by least squares over the inliers of all overlaps. An inlier's
// error is the difference between the corrected colours of both cameras. Each correction is
// regularised towards its chained correction.
void fit_jointly(const std::vector<Overlap>& overlaps,
                 std::vector<std::optional<ColorCorrection>>& corrections) {
  std::vector<int> unknown(corrections.size(), -1);
  int count = 0;
  for (std::size_t i = 1; i < corrections.size(); ++i) {
    if (corrections[i]) unknown[i] = count++;
  }
  if (count < 2) return;  // A single correction is fitted already.
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(4 * count, 4 * count);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(4 * count, 3);
  for (const Overlap& overlap : overlaps) {
    if (!corrections[overlap.from] || !corrections[overlap.to]) continue;
    const int a = unknown[overlap.from], b = unknown[overlap.to];
    for (const ColorPair& pair : overlap.fit.inliers) {
      const Eigen::Vector4d from(pair.from.x(), pair.from.y(), pair.from.z(), 1);
      const Eigen::Vector4d to(pair.to.x(), pair.to.y(), pair.to.z(), 1);
      const auto add = [&](int row, const Eigen::Vector4d& v, int column, const Eigen::Vector4d& w) {
        normal.block<4, 4>(4 * row, 4 * column) += v * w.transpose();
      };
      if (a >= 0) add(a, from, a, from);
      if (b >= 0) add(b, to, b, to);
      if (a >= 0 && b >= 0) {
        add(a, from, b, -to);
        add(b, to, a, -from);
      }
      // The colours of the reference are fixed.
      if (a >= 0 && b < 0) right.middleRows<4>(4 * a) += from * to.head<3>().transpose();
      if (b >= 0 && a < 0) right.middleRows<4>(4 * b) += to * from.head<3>().transpose();
    }
    const double hold = kHold * static_cast<double>(overlap.fit.inliers.size());
    for (const std::size_t camera : {overlap.from, overlap.to}) {
      const int i = unknown[camera];
      if (i < 0) continue;
      normal.diagonal().segment<4>(4 * i).array() += hold;
      right.middleRows<4>(4 * i) += hold * corrections[camera]->cast<double>().transpose();
    }
  }
  const Eigen::MatrixXd solved = normal.ldlt().solve(right);
  if (!solved.allFinite()) return;
  for (std::size_t i = 0; i < corrections.size(); ++i) {
    if (unknown[i] >= 0) corrections[i] = solved.middleRows<4>(4 * unknown[i]).transpose().cast<float>();
  }
}

}  // namespace

std::vector<std::optional<ColorCorrection>> match_colors(std::span<const PosedFrame> frames) {
  assert(!frames.empty());
  const auto overlaps = find_overlaps(frames);
  auto corrections = chain_to_reference(overlaps, frames.size());
  fit_jointly(overlaps, corrections);
  return corrections;
}

void SteadyCorrections::follow(std::span<const std::optional<ColorCorrection>> found, Duration elapsed) {
  assert(found.size() == corrections_.size());
  const double seconds = std::chrono::duration<double>(elapsed).count();
  const auto share = static_cast<float>(1 - std::exp(-seconds / kEaseSeconds));
  for (std::size_t i = 0; i < corrections_.size(); ++i) {
    if (!found[i]) continue;
    corrections_[i] = corrections_[i]
                          ? ColorCorrection(*corrections_[i] + share * (*found[i] - *corrections_[i]))
                          : *found[i];
  }
}

}  // namespace copresence::color_matching
