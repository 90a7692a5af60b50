#include "render_client/viewpoint/tracker_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::viewpoint {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr Instant kBegin{};

class TrackerReportTest : public testing::Test {
 protected:
  std::string line(Instant now) {
    const auto news = report_.next(now);
    return news ? news->text : "";
  }
  void refuse(DatagramFault fault, Instant now) {
    static constexpr std::array<std::uint8_t, 36> kBytes{};
    report_.refused(fault, kBytes, kBytes.size(), now);
  }
  TrackerReport report_{4242};
};

TEST_F(TrackerReportTest, SaysOnceThatNothingComesAndHowToMendIt) {
  EXPECT_EQ(line(kBegin), "");
  EXPECT_EQ(line(kBegin + milliseconds(4900)), "");
  const std::string silence = line(kBegin + seconds(5));
  EXPECT_THAT(silence, HasSubstr("port 4242: nothing has come in 5 s"));
  EXPECT_THAT(silence, HasSubstr("UDP over network"));
  for (int s = 6; s < 600; ++s) EXPECT_EQ(line(kBegin + seconds(s)), "");
}

TEST_F(TrackerReportTest, SaysThatPosesComeAndThatTheyCeased) {
  EXPECT_EQ(line(kBegin), "");
  report_.took_pose(kBegin + seconds(1));
  EXPECT_THAT(line(kBegin + seconds(1)), HasSubstr("poses arrive"));
  EXPECT_EQ(line(kBegin + seconds(5)), "");
  EXPECT_THAT(line(kBegin + seconds(6)), HasSubstr("nothing has come for 5 s"));
  report_.took_pose(kBegin + seconds(9));
  EXPECT_THAT(line(kBegin + seconds(9)), HasSubstr("poses arrive"));
  EXPECT_EQ(line(kBegin + seconds(15)), "");  // it was logged less than a minute ago
}

TEST_F(TrackerReportTest, NamesEachKindOfFaultAtOnceAndThenOnceAMinute) {
  EXPECT_EQ(line(kBegin), "");
  for (int i = 0; i < 250; ++i) refuse(DatagramFault::kSize, kBegin);
  refuse(DatagramFault::kNotFinite, kBegin);
  EXPECT_THAT(line(kBegin), HasSubstr("ignores 36 bytes (250 such)"));
  EXPECT_THAT(line(kBegin), HasSubstr("(1 such)"));
  EXPECT_EQ(line(kBegin), "");
  int lines = 0;
  for (int s = 1; s <= 600; ++s) {
    for (int i = 0; i < 250; ++i) refuse(DatagramFault::kSize, kBegin + seconds(s));
    lines += line(kBegin + seconds(s)).empty() ? 0 : 1;
  }
  EXPECT_EQ(lines, 10);
}

TEST_F(TrackerReportTest, DoesNotCallWrongDatagramsSilence) {
  EXPECT_EQ(line(kBegin), "");
  refuse(DatagramFault::kSize, kBegin + seconds(4));
  EXPECT_THAT(line(kBegin + seconds(4)), HasSubstr("36 bytes"));
  EXPECT_EQ(line(kBegin + seconds(6)), "");
}

}  // namespace
}  // namespace copresence::viewpoint
