#include "common/video/depth_rate_controller.h"

#include <algorithm>
#include <cassert>

namespace copresence::video {
namespace {

/// Aimed at, of the rate: what is left keeps a second with a keyframe inside the promise of 10 %.
constexpr double kShare = 0.99;
/// A picture may run ahead of its rate by this many frames' worth: below three, so that no frame exceeds
/// three times the mean, and so little that a second that begins frugal and ends in a keyframe stays
/// below 1.1 times the rate.
constexpr double kBufferFrames = 2.5;
/// What is saved is spent within about so many frames, and no more than kMostSaved frames' worth are kept for later: as much
/// again as a keyframe runs ahead, so that both in one second stay inside the promise. Spent in 8, it would not make up for an
/// encoder that leaves a quarter of what it may take, as x264 does where every picture differs from the one before.
constexpr double kSpendFrames = 5;
constexpr double kMostSaved = 1.5;
/// A keyframe's debt, up to kUsualDebt frames' worth, is paid back within about so many frames: faster, and where the mask takes
/// most of the rate, the pictures after it would get next to nothing and be bad for longer than that. More is paid back in
/// kRepayMoreFrames.
constexpr double kRepayFrames = 40;
constexpr double kRepayMoreFrames = 8;
constexpr double kUsualDebt = 2;
/// More is forgiven: when side data alone exceeds the rate for long, the picture must recover within a second
/// after.
constexpr double kMostOwed = 30;
/// Where the side data alone exceeds the rate, the picture still gets this share: x264 needs some.
constexpr double kLeastShare = 0.05;

}  // namespace

DepthRateController::DepthRateController(int kbps, double frames_per_second)
    : kbps_(kbps), frames_per_second_(frames_per_second) {
  assert(kbps > 0 && frames_per_second > 0);
}

double DepthRateController::frame_bits() const {
  return kbps_ * 1000 / frames_per_second_;
}

void DepthRateController::set_kbps(int kbps) {
  assert(kbps > 0);
  const double before = frame_bits();
  kbps_ = kbps;
  debt_bits_ *= frame_bits() / before;  // counted in frames, it is the same debt
}

PictureRate DepthRateController::picture_rate(std::size_t side_bytes) const {
  const double share = frame_bits() * kShare;
  const double slow = std::clamp(debt_bits_, 0.0, kUsualDebt * share);
  const double saved = std::min(debt_bits_, 0.0);
  const double repaid =
      slow / kRepayFrames + (debt_bits_ - slow - saved) / kRepayMoreFrames + saved / kSpendFrames;
  const double wanted = share - 8.0 * static_cast<double>(side_bytes) - repaid;
  const double bits = std::max(wanted, share * kLeastShare);
  return {bits * frames_per_second_ / 1000, frame_bits() * kBufferFrames / 1000};
}

void DepthRateController::spent(std::size_t bytes) {
  const double share = frame_bits() * kShare;
  debt_bits_ = std::clamp(debt_bits_ + 8.0 * static_cast<double>(bytes) - share, -kMostSaved * share,
                          kMostOwed * share);
}

}  // namespace copresence::video
