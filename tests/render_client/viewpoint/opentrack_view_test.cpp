#include "render_client/viewpoint/opentrack_view.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <limits>
#include <vector>

#include "render_client/viewpoint/look_at.h"

namespace copresence::viewpoint {
namespace {

using Eigen::Vector3d;

std::vector<std::uint8_t> datagram(const std::vector<double>& values) {
  std::vector<std::uint8_t> bytes;
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  return bytes;
}

/// A view that listens on a free port, and a tracker that sends to it over the loopback interface.
class Opentrack : public testing::Test {
 protected:
  Opentrack() {
    tracker_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address_.sin_port = htons(view.port());
  }
  ~Opentrack() override { ::close(tracker_); }

  /// On the loopback interface a datagram has arrived when sendto() returns.
  void send(const std::vector<std::uint8_t>& bytes) {
    ASSERT_EQ(::sendto(tracker_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&address_),
                       sizeof address_),
              static_cast<ssize_t>(bytes.size()));
  }
  Rigid3 eye() { return view.at(0, {}).world_from_eye; }

  OpentrackView view = OpentrackView::open({}, 0).value();

 private:
  int tracker_;
  sockaddr_in address_{};
};

TEST_F(Opentrack, StaysAtHomeUntilSomethingComes) {
  const Rigid3 home = look_at({1, 0, 0}, {0, 0, 0}, {0, -1, 0});
  view.set_reset_pose(home);
  EXPECT_EQ(eye(), home);
}

TEST_F(Opentrack, MovesTheEyeInMetresRightUpAndForward) {
  send(datagram({10, 20, 30, 0, 0, 0}));
  EXPECT_TRUE(eye().translation.isApprox(Vector3d(0.1, -0.2, 0.3)));
  EXPECT_TRUE(eye().rotation.isIdentity());
}

TEST_F(Opentrack, TurnsRightNodsUpAndTiltsRight) {
  send(datagram({0, 0, 0, 90, 0, 0}));
  EXPECT_TRUE(eye().rotation.col(2).isApprox(Vector3d(1, 0, 0), 1e-12));
  send(datagram({0, 0, 0, 0, 30, 0}));
  EXPECT_LT(eye().rotation.col(2).y(), -0.49);
  send(datagram({0, 0, 0, 0, 0, 30}));
  EXPECT_GT(eye().rotation.col(0).y(), 0.49);  // right has become down
}

TEST_F(Opentrack, StaysWhereTheHeadIsWhenAnEarlierListedCameraAppears) {
  view.set_reset_pose(look_at({5, 0, 0}, {0, 0, 0}, {0, -1, 0}));
  send(datagram({0, 0, 100, 0, 0, 0}));
  const Rigid3 before = view.at(0, {}).world_from_eye;
  view.set_reset_pose(look_at({0, 0, 7}, {0, 0, 0}, {0, -1, 0}));
  EXPECT_EQ(view.at(1, {}).world_from_eye, before);
}

TEST_F(Opentrack, AppliesTheHeadInTheFrameOfHome) {
  view.set_reset_pose(look_at({5, 0, 0}, {0, 0, 0}, {0, -1, 0}));
  send(datagram({0, 0, 100, 0, 0, 0}));
  EXPECT_TRUE(eye().translation.isApprox(Vector3d(4, 0, 0)));
}

TEST_F(Opentrack, TakesTheNewestAndHoldsIt) {
  for (int i = 1; i <= 20; ++i) send(datagram({double(i), 0, 0, 0, 0, 0}));
  EXPECT_DOUBLE_EQ(eye().translation.x(), 0.2);
  EXPECT_DOUBLE_EQ(eye().translation.x(), 0.2);
  EXPECT_EQ(view.counters().taken, 20u);
}

TEST_F(Opentrack, IgnoresAndCountsWhatIsNoHead) {
  send(datagram({7, 0, 0, 0, 0, 0}));
  send({});
  send({1, 2, 3});
  send(datagram({1, 2, 3, 4, 5}));
  send(datagram({1, 2, 3, 4, 5, 6, 7}));
  send(std::vector<std::uint8_t>(5000, 0));
  send(datagram({0, 0, std::numeric_limits<double>::quiet_NaN(), 0, 0, 0}));
  send(datagram({0, 0, 0, std::numeric_limits<double>::infinity(), 0, 0}));
  send(datagram({501, 0, 0, 0, 0, 0}));
  send(datagram({0, 0, 0, 0, 0, -181}));
  send(datagram({0, 1e300, 0, 0, 0, 0}));
  EXPECT_DOUBLE_EQ(eye().translation.x(), 0.07);
  EXPECT_EQ(view.counters().taken, 1u);
  EXPECT_EQ(view.counters().wrong_size, 5u);
  EXPECT_EQ(view.counters().not_finite, 2u);
  EXPECT_EQ(view.counters().out_of_range, 3u);
}

TEST_F(Opentrack, NamesWhatItIgnoresAndWhatItExpects) {
  send(std::vector<std::uint8_t>(300, 0));
  const auto news = view.news(Instant{});
  ASSERT_TRUE(news);
  EXPECT_TRUE(news->is_trouble);
  EXPECT_THAT(news->text, testing::HasSubstr("port " + std::to_string(view.port())));
  EXPECT_THAT(news->text, testing::HasSubstr("300 bytes"));
  EXPECT_THAT(news->text, testing::HasSubstr("six little-endian doubles"));
  EXPECT_FALSE(view.news(Instant{}));
}

TEST_F(Opentrack, TakesTheEndsOfTheRange) {
  send(datagram({500, -500, 500, 180, -180, 180}));
  EXPECT_TRUE(eye().is_rigid(1e-9));
  EXPECT_EQ(view.counters().taken, 1u);
}

TEST_F(Opentrack, SaysThatThePortIsInUse) {
  const auto second = OpentrackView::open({}, view.port());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(second.error().what,
              testing::HasSubstr("UDP port " + std::to_string(view.port()) + ": another program uses it"));
}

TEST_F(Opentrack, LetsThePortGoAtItsEnd) {
  std::uint16_t port;
  {
    OpentrackView moved = OpentrackView::open({}, 0).value();
    port = moved.port();
    const OpentrackView again = std::move(moved);
    EXPECT_FALSE(OpentrackView::open({}, port));
  }
  EXPECT_TRUE(OpentrackView::open({}, port));
}

}  // namespace
}  // namespace copresence::viewpoint
