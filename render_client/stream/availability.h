#pragma once

// Whether a camera can be shown, and when its server is tried again.
//
// Thread: values.

#include <chrono>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::stream {

enum class Availability {
  kAwaited,  ///< not connected, or without a frame yet: views wait for it
  kShown,    ///< its frames come and can be decoded
  /// Its server answers, but has sent nothing that can be shown for a while; views do without the
  /// camera.
  kLeftOut,
  kRefused,  ///< another protocol version or an unknown codec; views do without the camera
};

inline bool is_left_out(Availability availability) {
  return availability == Availability::kLeftOut || availability == Availability::kRefused;
}

/// Follows the connections of one camera. Time comes in as an argument and never goes back.
class AvailabilityTracker {
 public:
  /// The pause before the next try doubles with every failure, from the first to the longest. It
  /// becomes short again only after a connection whose frames decode for kSteady. So a server that
  /// welcomes clients and hangs up is not reconnected to without pause.
  static constexpr std::chrono::milliseconds kFirstPause{50}, kLongestPause{500};
  static constexpr std::chrono::seconds kSteady{2};
  /// How long a server may answer without one decodable frame. Then its camera is left out.
  static constexpr std::chrono::seconds kPatience{3};

  void connected();
  void decoded(Instant now);
  /// A frame has come that cannot be decoded.
  void undecodable(const std::string& why, Instant now);
  /// A connection has ended or could not be made. Returns the pause before the next try. Nothing if
  /// trying again is of no use (kRefused).
  std::optional<Duration> failed(const Error& why, Instant now);

  Availability availability() const { return availability_; }
  /// Why the camera is left out, as one sentence. Meaningless for other states.
  const std::string& reason() const { return reason_; }

 private:
  void in_trouble(const std::string& why, Instant now);

  Availability availability_ = Availability::kAwaited;
  std::string reason_;
  Duration next_pause_ = kFirstPause;
  std::optional<Instant> first_decoded_;  // of this connection
  std::optional<Instant> last_decoded_;
  // Since then the server has answered, and no frame has been decoded.
  std::optional<Instant> trouble_since_;
};

}  // namespace copresence::stream
