#pragma once

// Keeps every camera's colours matched to the first one's while frames come in (thesis 2.6.2): now and then, on a thread
// of its own, the newest frames are compared, and the render thread takes what is known.
//
// Only cameras whose place is known take part. What the scene file gives as a camera's `color_matching` is shown instead of
// what is found here.
// Thread: run() on one thread, the rest on the render thread.

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "render_client/camera_receiver.h"
#include "render_client/color_matching/color_matcher.h"

namespace copresence::client {

class LiveColorMatching {
 public:
  explicit LiveColorMatching(std::size_t cameras);

  /// A camera's newest frame; `placed` says where and how it sees, its `frame` pointing into `received`, which is kept
  /// until the next one.
  void show(std::size_t camera, std::shared_ptr<const Received> received,
            const color_matching::PosedFrame& placed);

  /// What takes this camera's colours to the first one's; identity while nothing is known.
  color_matching::ColorMap map(std::size_t camera) const;

  /// Compares until asked to stop.
  void run(std::stop_token stop);

 private:
  struct Camera {
    std::shared_ptr<const Received> received;
    color_matching::PosedFrame placed;
  };
  void compare(Duration elapsed);

  mutable std::mutex mutex_;
  std::vector<Camera> cameras_;  // guarded by mutex_, as is:
  color_matching::SteadyMaps steady_;
};

}  // namespace copresence::client
