#pragma once

// The one interface of everything that says where the eye stands: a pose, a scripted path, the mouse, a head
// tracker.
//
// Poses are world_from_eye in metres; the eye's frame is a camera's: x right, y down, z forward.
// Thread: one at a time.

#include <cstdint>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

/// Of one view. A head's window or headset will add its lens here.
struct Eye {
  Rigid3 world_from_eye;
};

/// A line for the log about what moves the eye.
struct News {
  bool is_trouble = false;
  std::string text;
};

class Viewpoint {
 public:
  virtual ~Viewpoint() = default;

  /// The eye of view `view_index`, counted from 0, which is drawn at `now`.
  virtual Eye at(std::uint64_t view_index, Instant now) = 0;

  /// Where the eye stands when nobody moves it: the first camera's pose, known once that camera is there.
  virtual void set_home(const Rigid3& world_from_home) = 0;

  /// What there is to say at `now`, one line at a time. Never waits; to be asked a few times a second.
  virtual std::optional<News> news(Instant) { return std::nullopt; }
};

}  // namespace copresence::viewpoint
