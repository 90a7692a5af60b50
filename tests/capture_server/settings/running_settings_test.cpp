#include "capture_server/running_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>
#include <thread>

#include "tests/capture_server/settings/settings_file.h"

namespace copresence::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Of a server that began with a file.
class RunningSettingsTest : public ::testing::Test {
 protected:
  RunningSettingsTest() {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink_));
    spdlog::set_pattern("%l: %v");
  }
  ~RunningSettingsTest() override { spdlog::set_default_logger(before_); }

  /// What is said of the file as it is now.
  std::string read_again() {
    said_.str("");
    running_.read_again();
    return said_.str();
  }

  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::ostringstream said_;
  std::shared_ptr<spdlog::sinks::ostream_sink_mt> sink_ =
      std::make_shared<spdlog::sinks::ostream_sink_mt>(said_);
  SettingsFile file_{"source = \"desk.oni\"\ndepth-kbps = 4000\n"};
  std::vector<const char*> arguments_ = file_.with();
  RunningSettings running_{static_cast<int>(arguments_.size()), arguments_.data(),
                           *read_command_line(static_cast<int>(arguments_.size()), arguments_.data())};
};

TEST_F(RunningSettingsTest, GiveNewRatesAndSayOldAndNew) {
  file_.write("source = \"desk.oni\"\ndepth-kbps = 1500\ncolor-kbps = 900\n");
  const std::string said = read_again();
  EXPECT_THAT(said, HasSubstr("desk.toml read again: color-kbps 2500 -> 900, depth-kbps 4000 -> 1500"));
  EXPECT_EQ(running_.encoder_changes().try_take(), (EncoderSettings{20, 1500, 900}));
  EXPECT_EQ(running_.now().encoder.depth_kbps, 1500);
}

TEST_F(RunningSettingsTest, GoFromARateToAQuantiser) {
  file_.write("source = \"desk.oni\"\ndepth-qp = 24\n");
  EXPECT_THAT(read_again(), HasSubstr("depth-kbps 4000 -> none, depth-qp 20 -> 24"));
  EXPECT_EQ(running_.encoder_changes().try_take(), (EncoderSettings{24, std::nullopt, 2500}));
}

TEST_F(RunningSettingsTest, NameWhatTakesARestartEveryTimeAndLeaveItAlone) {
  file_.write("source = \"desk.oni\"\ndepth-kbps = 4000\ncodec = \"quantized\"\nloop = true\n");
  for (int time = 0; time < 2; ++time) {
    const std::string said = read_again();
    EXPECT_THAT(said, HasSubstr("a restart of the server is needed for codec adaptive -> quantized, loop"));
    EXPECT_THAT(said, Not(HasSubstr("kbps")));
    EXPECT_EQ(running_.now().codec, "adaptive");
    EXPECT_EQ(running_.encoder_changes().try_take(), std::nullopt);
  }
}

TEST_F(RunningSettingsTest, SayWhenNothingHasChanged) {
  file_.write("# the same\ndepth-kbps = 4_000\nsource = \"desk.oni\"\n");
  EXPECT_THAT(read_again(), HasSubstr("desk.toml read again: nothing has changed"));
  EXPECT_EQ(running_.encoder_changes().try_take(), std::nullopt);
}

TEST_F(RunningSettingsTest, StayAsTheyAreWhereTheFileIsWrong) {
  for (const char* text : {"depth-kbps = 1500\nspeed = 3\n", "depth-kbps = ", "", "\xff\xfe"}) {
    file_.write(text);
    const std::string said = read_again();
    EXPECT_THAT(said, HasSubstr("warning: "));
    EXPECT_THAT(said, HasSubstr("everything goes on as before"));
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(running_.encoder_changes().try_take(), std::nullopt);
    EXPECT_EQ(running_.now().encoder.depth_kbps, 4000);
  }
}

TEST_F(RunningSettingsTest, WaitForAFileThatIsJustBeingWritten) {
  file_.write("");
  std::jthread editor([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
    file_.write("source = \"desk.oni\"\ndepth-kbps = 1500\n");
  });
  EXPECT_THAT(read_again(), HasSubstr("depth-kbps 4000 -> 1500"));
}

}  // namespace
}  // namespace copresence::server
