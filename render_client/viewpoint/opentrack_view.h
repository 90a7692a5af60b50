#pragma once

// An eye that follows a head tracker. It receives opentrack's output "UDP over network"
// (head_datagram.h, docs/guide/viewing.md).
//
// The head moves the eye from the reset pose by the translation (x, -y, z) / 100 in metres and the
// rotation Ry(yaw) Rx(pitch) Rz(roll). The axes of the eye's frame are x right, y down and z
// forward. If a tracker's axis has the opposite sign, invert it in opentrack's mapping. Invalid
// datagrams are counted and reported by news(). Thread: one thread at a time per object.

#include <cstdint>

#include "common/result.h"
#include "render_client/viewpoint/head_datagram.h"
#include "render_client/viewpoint/tracker_report.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::viewpoint {

/// Returns the motion of the head from the reset pose.
Rigid3 reset_from_eye(const HeadPose& head);

class OpentrackView final : public Viewpoint {
 public:
  static constexpr std::uint16_t kPort = 4242;

  struct Counters {
    std::uint64_t taken = 0;  ///< Number of valid datagrams.
    /// Numbers of ignored datagrams.
    std::uint64_t wrong_size = 0, wrong_byte_order = 0, not_finite = 0, out_of_range = 0;
  };

  /// Listens on the loopback interface. Port 0 means any. Fails with kUnavailable if it is in use.
  static Result<OpentrackView> open(const CameraModel& intrinsics, std::uint16_t port);

  OpentrackView(OpentrackView&& other) noexcept;
  OpentrackView& operator=(OpentrackView&& other) noexcept;
  ~OpentrackView() override;

  /// Returns the pose of the newest valid datagram, without extrapolation. Never waits.
  ViewPose at(std::uint64_t view_index, Instant display_time) override;
  /// Once a head pose has come, the first reset pose stays, so that the view does not jump.
  void set_reset_pose(const Rigid3& world_from_eye) override;
  std::optional<News> news(Instant now) override;

  const Counters& counters() const { return counters_; }
  std::uint16_t port() const { return port_; }

 private:
  OpentrackView(const CameraModel& intrinsics, int socket, std::uint16_t port)
      : Viewpoint(intrinsics), socket_(socket), port_(port), report_(port) {}
  void receive(Instant now);
  void take(std::span<const std::uint8_t> received, std::size_t size, Instant now);

  int socket_ = -1;
  std::uint16_t port_ = 0;
  Rigid3 world_from_reset_;
  bool has_reset_pose_ = false;
  HeadPose head_;
  Counters counters_;
  TrackerReport report_;
};

}  // namespace copresence::viewpoint
