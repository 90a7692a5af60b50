// --sync with real processes: a view shows frames of nearly one instant.

#include <gtest/gtest.h>

#include <thread>

#include "tests/pipeline/running_room.h"

namespace copresence::testing {
namespace {

TEST(Sync, AViewsPicturesAreHalfAPeriodApartAtMost) {
  RunningRoom room;
  room.serve(recordings() / "camera0.oni", {"--loop"});
  ASSERT_TRUE(room.server(0).says("camera0", std::chrono::seconds(10)));
  std::this_thread::sleep_for(std::chrono::milliseconds(110));  // a phase of its own
  room.serve(recordings() / "camera1.oni", {"--loop"});
  const auto stats = room.view({"--frames", "90", "--size", "320x180", "--sync"});
  bool frames_come = true;
  for (const auto& camera : stats["cameras"]) {
    EXPECT_EQ(camera["drops"]["unaccounted"], 0);
    frames_come = frames_come && camera["frames_decoded"] >= 0.9 * camera["frames_captured"].get<double>();
  }
  if (!frames_come) GTEST_SKIP() << "SKIPPED: this machine is too busy for two cameras at 30 frames a second";
  EXPECT_LT(stats["view"]["skew_ms"]["p50"], 17.0);
}

TEST(Sync, RecordingsThatBeginAtOneInstantAreInStep) {
  using namespace std::chrono;
  // Longer ahead than the supervisor lets a silent server live.
  const auto begin = system_clock::now() + seconds(7);
  const std::string at = std::to_string(duration<double>(begin.time_since_epoch()).count());
  RunningRoom room;
  room.serve(recordings() / "camera0.oni", {"--loop", "--start-at", at});
  std::this_thread::sleep_for(milliseconds(115));  // else a phase of its own: 15 ms
  room.serve(recordings() / "camera1.oni", {"--loop", "--start-at", at});
  const auto stats = room.view({"--frames", "60", "--size", "320x180", "--sync"});
  EXPECT_GT(system_clock::now(), begin);
  EXPECT_TRUE(room.server(0).says("begins in", seconds(1)));
  bool frames_come = true;
  for (const auto& camera : stats["cameras"])
    frames_come = frames_come && camera["frames_decoded"] >= 0.9 * camera["frames_captured"].get<double>();
  if (!frames_come) GTEST_SKIP() << "SKIPPED: this machine is too busy for two cameras at 30 frames a second";
  EXPECT_LT(stats["view"]["skew_ms"]["p50"], 7.0);
}

TEST(Sync, ACameraThatDiesHoldsUpNobody) {
  RunningRoom room;
  room.serve(recordings() / "camera0.oni", {"--loop"});
  room.serve(recordings() / "camera1.oni", {"--loop"});
  Process& client = room.look({"--frames", "90", "--size", "320x180", "--sync"});
  ASSERT_TRUE(client.says("connected to camera \"camera1\"", std::chrono::seconds(10)));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  room.kill_server(1);
  EXPECT_EQ(client.wait(std::chrono::seconds(10)), 0) << client.output();
}

}  // namespace
}  // namespace copresence::testing
