#include "render_client/viewpoint/opentrack_view.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <numbers>
#include <system_error>
#include <utility>

namespace copresence::viewpoint {
namespace {

constexpr std::size_t kDatagramBytes = 6 * sizeof(double);
constexpr double kMostCentimetres = 500, kMostDegrees = 180;
/// Trackers send 250 a second; beyond this many at one view somebody floods the port, and the view must go
/// on.
constexpr int kMostDatagramsAtOnce = 1000;

double little_endian_double(std::span<const std::uint8_t> bytes) {
  std::uint64_t bits = 0;
  for (int i = 7; i >= 0; --i) bits = bits << 8 | bytes[static_cast<std::size_t>(i)];
  return std::bit_cast<double>(bits);
}

auto failure(std::uint16_t port, int error) {
  const std::string why =
      error == EADDRINUSE ? "another program uses it; end that one" : std::generic_category().message(error);
  return fail(ErrorCode::kUnavailable,
              fmt::format("cannot listen for the head tracker on UDP port {}: {}", port, why));
}

}  // namespace

Rigid3 home_from_eye(const HeadPose& head) {
  constexpr double kRadians = std::numbers::pi / 180;
  Rigid3 pose;
  pose.rotation = (Eigen::AngleAxisd(head.yaw_degrees * kRadians, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(head.pitch_degrees * kRadians, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(head.roll_degrees * kRadians, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation = Eigen::Vector3d(head.x_cm, -head.y_cm, head.z_cm) / 100;
  return pose;
}

Result<OpentrackView> OpentrackView::open(std::uint16_t port) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return failure(port, errno);
  OpentrackView view(descriptor, port);  // owns the descriptor from here on
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(descriptor, generic, size) != 0 || ::getsockname(descriptor, generic, &size) != 0)
    return failure(port, errno);
  view.port_ = ntohs(address.sin_port);
  return view;
}

OpentrackView::OpentrackView(OpentrackView&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      port_(other.port_),
      world_from_home_(std::move(other.world_from_home_)),
      head_(other.head_),
      counters_(other.counters_) {}

OpentrackView& OpentrackView::operator=(OpentrackView&& other) noexcept {
  std::swap(socket_, other.socket_);
  port_ = other.port_;
  world_from_home_ = other.world_from_home_;
  head_ = other.head_;
  counters_ = other.counters_;
  return *this;
}

OpentrackView::~OpentrackView() {
  if (socket_ >= 0) ::close(socket_);
}

Eye OpentrackView::at(std::uint64_t, Instant) {
  std::array<std::uint8_t, kDatagramBytes + 1> bytes;  // one more shows what is too long
  for (int i = 0; i < kMostDatagramsAtOnce; ++i) {
    const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
    if (size < 0) break;  // nothing more now
    take(std::span(bytes).first(static_cast<std::size_t>(size)));
  }
  return {world_from_home_ * home_from_eye(head_)};
}

void OpentrackView::take(std::span<const std::uint8_t> datagram) {
  if (datagram.size() != kDatagramBytes) {
    ++counters_.malformed;
    return;
  }
  std::array<double, 6> values;
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = little_endian_double(datagram.subspan(8 * i, 8));
  if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); })) {
    ++counters_.not_finite;
    return;
  }
  const auto within = [&](std::size_t first, double most) {
    return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(first),
                       values.begin() + static_cast<std::ptrdiff_t>(first + 3),
                       [most](double value) { return std::abs(value) <= most; });
  };
  if (!within(0, kMostCentimetres) || !within(3, kMostDegrees)) {
    ++counters_.out_of_range;
    return;
  }
  head_ = {values[0], values[1], values[2], values[3], values[4], values[5]};
  ++counters_.taken;
}

}  // namespace copresence::viewpoint
