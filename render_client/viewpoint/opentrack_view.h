#pragma once

// An eye that follows a head tracker: opentrack's output "UDP over network" (head_datagram.h,
// docs/guide/viewing.md).
//
// The head moves the eye from home by
//
//   translation (x, -y, z) / 100 in metres,  rotation Ry(yaw) Rx(pitch) Rz(roll) in the eye's frame (x right,
//   y down, z forward), so that the head first turns, then nods, then tilts.
//
// An axis that a tracker gives the other way round is inverted in opentrack's mapping. Anything may arrive on
// a port: what is no head pose is counted and named in news(). Thread: one at a time.

#include <cstdint>

#include "common/result.h"
#include "render_client/viewpoint/head_datagram.h"
#include "render_client/viewpoint/tracker_report.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

/// The head's pose as a transform of the eye's frame.
Rigid3 home_from_eye(const HeadPose& head);

class OpentrackView final : public Viewpoint {
 public:
  static constexpr std::uint16_t kPort = 4242;

  struct Counters {
    std::uint64_t taken = 0;  ///< valid datagrams, shown or replaced by a newer one before a view
    std::uint64_t wrong_size = 0, wrong_byte_order = 0, not_finite = 0, out_of_range = 0;  ///< ignored ones
  };

  /// Listens on the loopback interface; port 0 takes any free one.
  /// Fails with kUnavailable and a sentence when the port is in use.
  static Result<OpentrackView> open(std::uint16_t port = kPort);

  OpentrackView(OpentrackView&& other) noexcept;
  OpentrackView& operator=(OpentrackView&& other) noexcept;
  ~OpentrackView() override;

  /// Takes what has arrived; the newest valid datagram counts, and stays until the next. Never waits.
  Eye at(std::uint64_t view_index, Instant now) override;
  void set_home(const Rigid3& world_from_home) override { world_from_home_ = world_from_home; }
  std::optional<News> news(Instant now) override;

  const Counters& counters() const { return counters_; }
  std::uint16_t port() const { return port_; }

 private:
  OpentrackView(int socket, std::uint16_t port) : socket_(socket), port_(port), report_(port) {}
  void take_what_has_come(Instant now);
  void take(std::span<const std::uint8_t> received, std::size_t size, Instant now);

  int socket_ = -1;
  std::uint16_t port_ = 0;
  Rigid3 world_from_home_;
  HeadPose head_;
  Counters counters_;
  TrackerReport report_;
};

}  // namespace copresence::viewpoint
