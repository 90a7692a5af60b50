#pragma once

// Decides whether a camera can be shown, and when to connect to its server again. Thread: different
// objects may be used at the same time.

#include <chrono>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::stream {

enum class Availability {
  kAwaited,  ///< The camera is not connected or has sent no frame yet. Views wait for it.
  kShown,    ///< Frames arrive and can be decoded.
  kLeftOut,  ///< The server answers, but has sent no decodable frame for a while.
  kRefused,  ///< Another protocol version, another room key, or an unknown codec.
};

inline bool is_left_out(Availability availability) {
  return availability == Availability::kLeftOut || availability == Availability::kRefused;
}

/// Follows the connections of one camera. Times are passed as arguments and must never decrease.
class AvailabilityTracker {
 public:
  /// The pause before the next try doubles with every failure, from kFirstPause to kLongestPause.
  /// It becomes short again only after a connection whose frames could be decoded for kSteady. This
  /// limits the tries if a server accepts and closes connections.
  static constexpr std::chrono::milliseconds kFirstPause{50}, kLongestPause{500};
  static constexpr std::chrono::seconds kSteady{2};
  /// A camera is left out if its server answers for this time without a single decodable frame.
  static constexpr std::chrono::seconds kPatience{3};

  void connected();
  void decoded(Instant now);
  /// Call it when a frame cannot be decoded.
  void undecodable(const std::string& why, Instant now);
  /// Call it when a connection has ended or could not be made. Returns the pause before the next
  /// try, or nothing in the state kRefused, in which no further try can succeed.
  std::optional<Duration> failed(const Error& why, Instant now);

  Availability availability() const { return availability_; }
  /// Returns the reason why the camera is left out or refused, as one sentence.
  const std::string& reason() const { return reason_; }

 private:
  void in_trouble(const std::string& why, Instant now);

  Availability availability_ = Availability::kAwaited;
  std::string reason_;
  Duration next_pause_ = kFirstPause;
  std::optional<Instant> first_decoded_;  // Of this connection.
  std::optional<Instant> last_decoded_;
  // Since this time, the server has answered and no frame has been decoded.
  std::optional<Instant> trouble_since_;
};

}  // namespace copresence::stream
