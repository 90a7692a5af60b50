#pragma once

// Whether a camera can be shown, and when its server is tried again.
//
// Thread: values.

#include <chrono>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::client {

enum class Availability {
  kAwaited,  ///< not connected, or without a frame yet: views wait for it
  kShown,    ///< its frames come and decode
  kLeftOut,  ///< its server answers, but for a while nothing has come that can be shown; views do without it
  kRefused,  ///< cannot be shown as it is: another protocol version, an unknown codec; views do without it
};

inline bool is_left_out(Availability availability) {
  return availability == Availability::kLeftOut || availability == Availability::kRefused;
}

/// Follows one camera's connections. Time comes in as an argument and never goes back.
class AvailabilityTracker {
 public:
  /// The pause before the next try doubles from the first to the longest with every failure. Only a
  /// connection whose frames decode for kSteady makes it short again: a server that welcomes and hangs up
  /// must not be reconnected to without end.
  static constexpr std::chrono::milliseconds kFirstPause{50}, kLongestPause{500};
  static constexpr std::chrono::seconds kSteady{2};
  /// How long a server may answer without one decodable frame before its camera is left out.
  static constexpr std::chrono::seconds kPatience{3};

  void connected();
  void decoded(Instant now);
  /// A frame came that does not decode.
  void undecodable(const std::string& why, Instant now);
  /// The connection ended or could not be made. Returns the pause before the next try, or nothing where
  /// trying again is of no use: kRefused.
  std::optional<Duration> failed(const Error& why, Instant now);

  Availability availability() const { return availability_; }
  /// Why the camera is left out, one sentence; meaningless otherwise.
  const std::string& reason() const { return reason_; }

 private:
  void in_trouble(const std::string& why, Instant now);

  Availability availability_ = Availability::kAwaited;
  std::string reason_;
  Duration next_pause_ = kFirstPause;
  std::optional<Instant> first_decoded_;  // of this connection
  std::optional<Instant> last_decoded_;
  std::optional<Instant> trouble_since_;  // its server has answered since then, and nothing has decoded
};

}  // namespace copresence::client
