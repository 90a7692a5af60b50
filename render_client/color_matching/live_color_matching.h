#pragma once

// Matches the colours of every camera to those of the first camera while frames arrive (thesis
// 2.6.2). The newest frames are compared twice a second on a separate thread.
//
// Only cameras with a known pose take part. A correction in the scene file replaces the correction
// that is found here. Thread: call run() on one thread, and all other functions on another thread.

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "render_client/camera_setup/camera_setup.h"
#include "render_client/color_matching/color_matcher.h"

namespace copresence::color_matching {

/// Makes the input of colour matching from a frame. `frame` must outlive the result.
PosedFrame posed_frame(const client::CameraFrame& frame);

class LiveColorMatching {
 public:
  explicit LiveColorMatching(std::size_t cameras);

  /// Sets the camera's newest frame. It is kept until the next call.
  void show(std::size_t camera, std::shared_ptr<const client::CameraFrame> frame);

  /// Excludes the camera until its next show(). Its correction stays.
  void forget(std::size_t camera);

  enum class FirstMatch { kAwaited, kFound, kGivenUp };
  /// Returns the progress of the first match of these cameras: kFound once all have a correction.
  /// The result kGivenUp means that some still have none after kRoundsToGiveUp comparisons each.
  FirstMatch first_match(std::span<const std::size_t> cameras) const;
  static constexpr int kRoundsToGiveUp = 3;
  bool is_matched(std::size_t camera) const;

  /// Returns the correction from this camera's colours to those of the first camera. It is the
  /// identity as long as no correction is known.
  ColorCorrection correction(std::size_t camera) const;

  /// Compares the newest frames until a stop is requested.
  void run(std::stop_token stop);

  /// Compares the newest frames now if a comparison is due at `now`. Call it for every view of a
  /// replay instead of run(), so that the corrections depend on the recording only.
  void compare_if_due(Instant now);
  /// Compares the newest frames now. `elapsed` is the time since the last comparison.
  void compare(Duration elapsed);

 private:
  using Frames = std::vector<std::shared_ptr<const client::CameraFrame>>;
  Duration until_next_round() const;

  mutable std::mutex mutex_;
  // The following members are guarded by mutex_.
  Frames newest_;            // By camera. Null if the camera takes no part.
  std::vector<int> rounds_;  // Number of comparisons by camera.
  SteadyCorrections steady_;

  std::optional<Instant> compared_at_;  // Used by compare_if_due() only.
};

}  // namespace copresence::color_matching
