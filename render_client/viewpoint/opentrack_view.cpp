#include "render_client/viewpoint/opentrack_view.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cerrno>
#include <numbers>
#include <system_error>
#include <utility>

namespace copresence::viewpoint {
namespace {

/// Trackers send 250 datagrams a second. The limit keeps the view running if the port is flooded.
constexpr int kMostDatagramsAtOnce = 1000;

auto failure(std::uint16_t port, int error) {
  const std::string why =
      error == EADDRINUSE ? "another program uses it; end that one" : std::generic_category().message(error);
  return fail(ErrorCode::kUnavailable,
              fmt::format("cannot listen for the head tracker on UDP port {}: {}", port, why));
}

}  // namespace

Rigid3 reset_from_eye(const HeadPose& head) {
  constexpr double kRadians = std::numbers::pi / 180;
  Rigid3 pose;
  pose.rotation = (Eigen::AngleAxisd(head.yaw_degrees * kRadians, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(head.pitch_degrees * kRadians, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(head.roll_degrees * kRadians, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation = Eigen::Vector3d(head.x_cm, -head.y_cm, head.z_cm) / 100;
  return pose;
}

Result<OpentrackView> OpentrackView::open(const CameraModel& intrinsics, std::uint16_t port) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return failure(port, errno);
  OpentrackView view(intrinsics, descriptor, port);  // `view` owns the descriptor from here on.
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(descriptor, generic, size) != 0 || ::getsockname(descriptor, generic, &size) != 0)
    return failure(port, errno);
  view.port_ = ntohs(address.sin_port);
  view.report_ = TrackerReport(view.port_);
  return view;
}

OpentrackView::OpentrackView(OpentrackView&& other) noexcept
    : Viewpoint(other),
      socket_(std::exchange(other.socket_, -1)),
      port_(other.port_),
      world_from_reset_(std::move(other.world_from_reset_)),
      has_reset_pose_(other.has_reset_pose_),
      head_(other.head_),
      counters_(other.counters_),
      report_(std::move(other.report_)) {}

OpentrackView& OpentrackView::operator=(OpentrackView&& other) noexcept {
  Viewpoint::operator=(other);
  std::swap(socket_, other.socket_);
  port_ = other.port_;
  world_from_reset_ = other.world_from_reset_;
  has_reset_pose_ = other.has_reset_pose_;
  head_ = other.head_;
  counters_ = other.counters_;
  report_ = std::move(other.report_);
  return *this;
}

OpentrackView::~OpentrackView() {
  if (socket_ >= 0) ::close(socket_);
}

void OpentrackView::set_reset_pose(const Rigid3& world_from_eye) {
  if (has_reset_pose_ && counters_.taken > 0) return;
  world_from_reset_ = world_from_eye;
  has_reset_pose_ = true;
}

ViewPose OpentrackView::at(std::uint64_t, Instant display_time) {
  receive(display_time);
  return pose_at(world_from_reset_ * reset_from_eye(head_));
}

std::optional<News> OpentrackView::news(Instant now) {
  receive(now);
  return report_.next(now);
}

void OpentrackView::receive(Instant now) {
  std::array<std::uint8_t, 256> bytes;
  for (int i = 0; i < kMostDatagramsAtOnce; ++i) {
    // With MSG_TRUNC, recv() returns the size of the whole datagram even if only a part of it fits.
    const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), MSG_TRUNC);
    if (size < 0) break;
    const auto whole = static_cast<std::size_t>(size);
    take(std::span(bytes).first(std::min(whole, bytes.size())), whole, now);
  }
}

void OpentrackView::take(std::span<const std::uint8_t> received, std::size_t size, Instant now) {
  const auto head = read_head_pose(received, size);
  if (head) {
    head_ = *head;
    ++counters_.taken;
    return report_.took_pose(now);
  }
  switch (head.error()) {
    case DatagramFault::kSize:
      ++counters_.wrong_size;
      break;
    case DatagramFault::kByteOrder:
      ++counters_.wrong_byte_order;
      break;
    case DatagramFault::kNotFinite:
      ++counters_.not_finite;
      break;
    case DatagramFault::kOutOfRange:
      ++counters_.out_of_range;
      break;
  }
  report_.refused(head.error(), received, size, now);
}

}  // namespace copresence::viewpoint
