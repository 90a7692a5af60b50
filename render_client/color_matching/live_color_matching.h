#pragma once

// Keeps the colours of every camera matched to those of the first one while frames come in (thesis
// 2.6.2). The newest frames are compared twice a second on a thread of their own.
//
// Only cameras with a known pose take part. A correction from the scene file is used instead of the
// one found here.
//
// Thread: run() on one thread, everything else on another.

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <vector>

#include "render_client/camera_setup/camera_setup.h"
#include "render_client/color_matching/color_matcher.h"

namespace copresence::color_matching {

/// A camera's frame as matching takes it. It points into `frame`.
PosedFrame posed_frame(const client::CameraFrame& frame);

class LiveColorMatching {
 public:
  explicit LiveColorMatching(std::size_t cameras);

  /// Gives the camera's newest frame, which is kept until the next one.
  void show(std::size_t camera, std::shared_ptr<const client::CameraFrame> frame);

  /// The camera takes no part until its next show(). Its correction stays.
  void forget(std::size_t camera);

  enum class FirstMatch { kAwaited, kFound, kGivenUp };
  /// Progress of the first match of these cameras. kFound once each has a correction. kGivenUp if
  /// some have none after each took part in kRoundsToGiveUp comparisons.
  FirstMatch first_match(std::span<const std::size_t> cameras) const;
  static constexpr int kRoundsToGiveUp = 3;
  bool is_matched(std::size_t camera) const;

  /// From this camera's colours to those of the first one; identity while nothing is known.
  ColorCorrection correction(std::size_t camera) const;

  /// Compares frames until asked to stop.
  void run(std::stop_token stop);

 private:
  using Frames = std::vector<std::shared_ptr<const client::CameraFrame>>;
  void compare(Duration elapsed);
  Duration until_next_round() const;

  mutable std::mutex mutex_;
  // Guarded by mutex_.
  Frames newest_;            // by camera; null: takes no part
  std::vector<int> rounds_;  // comparisons that each camera has taken part in
  SteadyCorrections steady_;
};

}  // namespace copresence::color_matching
