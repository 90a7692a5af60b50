#pragma once

// Makes the log lines about a head tracker. They say whether poses, invalid datagrams or no
// datagrams arrive. Each kind of invalid datagram is logged at once, and then at most once a
// minute. Thread: one thread at a time per object.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "render_client/viewpoint/head_datagram.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

class TrackerReport {
 public:
  /// A line is logged after this time without a datagram.
  static constexpr std::chrono::seconds kSilence{5};
  /// The minimum time between two lines of one kind.
  static constexpr std::chrono::seconds kBetweenLines{60};

  explicit TrackerReport(std::uint16_t port) : port_(port) {}

  void took_pose(Instant now);
  /// Takes the arguments of read_head_pose().
  void refused(DatagramFault fault, std::span<const std::uint8_t> received, std::size_t size, Instant now);

  /// Returns the next line to log at `now`, if there is one.
  std::optional<News> next(Instant now);

 private:
  struct Kind {
    std::uint64_t unsaid = 0;  ///< Number of datagrams since the last line.
    std::string latest;        ///< Description of the last datagram, or empty once it is logged.
    std::optional<Instant> said_at;
  };
  bool may_say(const std::optional<Instant>& said_at, Instant now) const {
    return !said_at || now - *said_at >= kBetweenLines;
  }
  std::string where() const;

  std::uint16_t port_;
  std::optional<Instant> began_at_, heard_at_;  ///< Times of the start and of the last datagram.
  bool has_pose_ = false, is_silent_ = false, pose_is_unsaid_ = false;
  std::optional<Instant> silence_said_at_;
  std::array<Kind, kDatagramFaults> kinds_;
};

}  // namespace copresence::viewpoint
