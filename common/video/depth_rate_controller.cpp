#include "common/video/depth_rate_controller.h"

#include <algorithm>
#include <cassert>

namespace copresence::video {
namespace {

/// Target share of the rate, which keeps a second with a keyframe within 10 % of the rate.
constexpr double kShare = 0.99;
/// Size of x264's buffer, in frames. A value below 3 keeps every frame below three times the mean.
/// The limit also keeps a second of small frames and a final keyframe below 1.1 times the rate.
constexpr double kBufferFrames = 2.5;
/// Saved bits are spent within about kSpendFrames. At most kMostSaved frames' worth are saved, so
/// that they and a keyframe fit into one second. Spending these bits in 8 frames would be too slow:
/// if every picture differs from the one before, x264 leaves a quarter of its rate unused.
constexpr double kSpendFrames = 5;
constexpr double kMostSaved = 1.5;
/// A keyframe fills the bucket by up to kUsualLevel frames' worth, which drains within about
/// kDrainFrames. If the bucket drained faster and the mask took most of the rate, the next pictures
/// would get almost no bits. Any excess above that level drains in kDrainExcessFrames.
constexpr double kDrainFrames = 40;
constexpr double kDrainExcessFrames = 8;
constexpr double kUsualLevel = 2;
/// Highest level of the bucket, in frames. The limit lets the picture recover within a second after
/// the side data alone has exceeded the rate.
constexpr double kMostLevel = 30;
/// The picture's share if the side data alone exceeds the rate, since x264 needs some bits.
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
  bucket_bits_ *= frame_bits() / before;  // Keeps the level unchanged, measured in frames.
}

PictureRate DepthRateController::picture_rate(std::size_t side_bytes) const {
  const double share = frame_bits() * kShare;
  const double usual = std::clamp(bucket_bits_, 0.0, kUsualLevel * share);
  const double saved = std::min(bucket_bits_, 0.0);
  const double drained =
      usual / kDrainFrames + (bucket_bits_ - usual - saved) / kDrainExcessFrames + saved / kSpendFrames;
  const double wanted = share - 8.0 * static_cast<double>(side_bytes) - drained;
  const double bits = std::max(wanted, share * kLeastShare);
  return {bits * frames_per_second_ / 1000, frame_bits() * kBufferFrames / 1000};
}

void DepthRateController::spent(std::size_t bytes) {
  const double share = frame_bits() * kShare;
  bucket_bits_ = std::clamp(bucket_bits_ + 8.0 * static_cast<double>(bytes) - share, -kMostSaved * share,
                            kMostLevel * share);
}

}  // namespace copresence::video
