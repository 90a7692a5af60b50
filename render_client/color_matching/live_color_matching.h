#pragma once

// Keeps every camera's colours matched to the first one's while frames come in (thesis 2.6.2): now and then,
// on a thread of its own, the newest frames are compared, and the render thread takes what is known.
//
// Only cameras whose place is known take part. What the scene file gives as a camera's `color_matching` is
// shown instead of what is found here.
// Thread: run() on one thread, the rest on the render thread.

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <vector>

#include "render_client/color_matching/color_matcher.h"
#include "render_client/stream/camera_receiver.h"

namespace copresence::client {

class LiveColorMatching {
 public:
  explicit LiveColorMatching(std::size_t cameras);

  /// A camera's newest frame; `placed` says where and how it sees, its `frame` pointing into `received`,
  /// which is kept until the next one.
  void show(std::size_t camera, std::shared_ptr<const Received> received,
            const color_matching::PosedFrame& placed);

  /// The camera takes no part until its next show(); its map stays.
  void forget(std::size_t camera);

  enum class FirstMatch { kAwaited, kFound, kGivenUp };
  /// How far the first match of these cameras is: kFound once each has a map, kGivenUp where some have none
  /// after each took part in kRoundsToGiveUp comparisons.
  FirstMatch first_match(std::span<const std::size_t> cameras) const;
  static constexpr int kRoundsToGiveUp = 3;
  bool is_matched(std::size_t camera) const;

  /// What takes this camera's colours to the first one's; identity while nothing is known.
  color_matching::ColorCorrection map(std::size_t camera) const;

  /// Compares until asked to stop.
  void run(std::stop_token stop);

 private:
  struct Camera {
    std::shared_ptr<const Received> received;
    color_matching::PosedFrame placed;
  };
  void compare(Duration elapsed);
  Duration until_next_round() const;

  mutable std::mutex mutex_;
  // Guarded by mutex_.
  std::vector<Camera> cameras_;
  std::vector<int> rounds_;  // that each camera has taken part in
  color_matching::SteadyMaps steady_;
};

}  // namespace copresence::client
