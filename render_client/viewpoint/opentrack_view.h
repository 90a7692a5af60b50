#pragma once

// An eye that follows a head tracker: opentrack's output "UDP over network".
//
// A datagram is six little-endian doubles: x, y, z in centimetres, yaw, pitch, roll in degrees. Positive is
// right, up and forward, and turned right, up and tilted to the right shoulder, as opentrack documents it (an
// axis that a tracker gives the other way round is inverted in opentrack's mapping). The head moves the eye
// from home by
//
//   translation (x, -y, z) / 100 in metres,  rotation Ry(yaw) Rx(pitch) Rz(roll) in the eye's frame (x right,
//   y down, z forward), so that the head first turns, then nods, then tilts.
//
// Anything may arrive on a port: only datagrams of 48 bytes with finite numbers in range count, the rest is
// counted. Thread: one at a time.

#include <array>
#include <cstdint>
#include <span>

#include "common/result.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

/// As it travels.
struct HeadPose {
  double x_cm = 0, y_cm = 0, z_cm = 0;                          ///< within 500
  double yaw_degrees = 0, pitch_degrees = 0, roll_degrees = 0;  ///< within 180
};

/// The head's pose as a transform of the eye's frame.
Rigid3 home_from_eye(const HeadPose& head);

class OpentrackView final : public Viewpoint {
 public:
  static constexpr std::uint16_t kPort = 4242;

  struct Counters {
    std::uint64_t taken = 0;       ///< valid datagrams, shown or replaced by a newer one before a view
    std::uint64_t malformed = 0;   ///< of another size
    std::uint64_t not_finite = 0;  ///< with a NaN or an infinity
    std::uint64_t out_of_range = 0;
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

  const Counters& counters() const { return counters_; }
  std::uint16_t port() const { return port_; }

 private:
  OpentrackView(int socket, std::uint16_t port) : socket_(socket), port_(port) {}
  void take(std::span<const std::uint8_t> datagram);

  int socket_ = -1;
  std::uint16_t port_ = 0;
  Rigid3 world_from_home_;
  HeadPose head_;
  Counters counters_;
};

}  // namespace copresence::viewpoint
