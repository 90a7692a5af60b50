#include "capture_server/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/capture_server/settings/settings_file.h"

namespace copresence::server {
namespace {

using ::testing::HasSubstr;

using Arguments = std::vector<const char*>;

ServerSettings settings_of(const Arguments& arguments) {
  const auto settings = read_command_line(static_cast<int>(arguments.size()), arguments.data());
  EXPECT_TRUE(settings);
  return settings ? *settings : ServerSettings();
}

/// What a file is refused with.
std::string refusal(const std::string& text, const Arguments& more = {"--source", "desk.oni"}) {
  SettingsFile file(text);
  const Arguments arguments = file.with(more);
  ::testing::internal::CaptureStderr();
  const auto settings = read_command_line(static_cast<int>(arguments.size()), arguments.data());
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(settings ? 0 : settings.error(), 2);
  return said;
}

TEST(Settings, ComeFromTheFileWhereTheCommandLineDoesNotGiveThem) {
  SettingsFile file(
      "source = \"openni:\"\nname = \"left\"\ndepth-kbps = 1500\nrange = \"0.5:4\"\nhole-filling = "
      "\"median\"\n"
      "insecure = true\nloop = false\n");
  const ServerSettings settings = settings_of(file.with());
  EXPECT_EQ(settings.source, "openni:");
  EXPECT_EQ(settings.name, "left");
  EXPECT_EQ(settings.rates.depth_kbps, 1500);
  EXPECT_EQ(settings.range.near_m, 0.5);
  EXPECT_EQ(settings.hole_filling, hole_filling::Method::kMedian);
  EXPECT_TRUE(settings.insecure);
  EXPECT_FALSE(settings.loop);
  EXPECT_EQ(settings.codec, "adaptive");  // by default

  const ServerSettings over = settings_of(file.with({"--name", "right", "--depth-kbps", "900"}));
  EXPECT_EQ(over.name, "right");
  EXPECT_EQ(over.rates.depth_kbps, 900);
  EXPECT_EQ(over.source, "openni:");
}

TEST(Settings, OfTheFileGiveWayToTheirOppositeOnTheCommandLine) {
  SettingsFile file("depth-kbps = 1500\n");
  const ServerSettings settings = settings_of(file.with({"--source", "desk.oni", "--depth-qp", "12"}));
  EXPECT_EQ(settings.rates.depth_qp, 12);
  EXPECT_EQ(settings.rates.depth_kbps, std::nullopt);
}

TEST(Settings, OnlyARecordingAtItsOwnPaceHasABeginning) {
  EXPECT_EQ(settings_of({"capture_server", "--source", "desk.oni", "--start-at", "1800000000.25"}).start_at,
            1800000000.25);
  EXPECT_THAT(refusal("start-at = 1800000000\n", {"--source", "simulated:room"}), HasSubstr("no beginning"));
  EXPECT_THAT(refusal("start-at = 1800000000\npace = \"fast\"\n"), HasSubstr("--pace fast"));
}

TEST(Settings, ACodecMayHaveItsParameters) {
  EXPECT_EQ(settings_of({"capture_server", "--source", "desk.oni", "--codec", "triangle:period=0.8"}).codec,
            "triangle:period=0.8");
  EXPECT_THAT(refusal("codec = \"triangle:period=far\"\n"), HasSubstr("takes only period=METRES"));
  EXPECT_THAT(refusal("codec = \"adaptive:period=0.8\"\n"), HasSubstr("takes no parameters"));
}

TEST(Settings, PathsInTheFileAreRelativeToIt) {
  SettingsFile file("source = \"desk.oni\"\nscene = \"room/scene.toml\"\nrecord = \"/tmp/x.oni\"\n");
  const ServerSettings settings = settings_of(file.with());
  EXPECT_EQ(settings.source, file.in_folder("desk.oni"));
  EXPECT_EQ(settings.scene, file.in_folder("room/scene.toml"));
  EXPECT_EQ(settings.record, "/tmp/x.oni");
  EXPECT_EQ(settings.name, "desk");
}

TEST(Settings, WhatIsWrongInTheFileIsOneLineWithItsPlace) {
  const std::string unknown = refusal("loop = true\ndepth-kpbs = 1500\n");
  EXPECT_THAT(unknown, HasSubstr("desk.toml:2: there is no setting \"depth-kpbs\""));
  EXPECT_EQ(std::count(unknown.begin(), unknown.end(), '\n'), 1);
  EXPECT_THAT(refusal("depth-kbps = 5\n"), HasSubstr("desk.toml:1: "));
  EXPECT_THAT(refusal("depth-kbps = \"fast\"\n"), HasSubstr("desk.toml:1: "));
  EXPECT_THAT(refusal("loop = \"perhaps\"\n"), HasSubstr("desk.toml:1: "));
  EXPECT_THAT(refusal("codec = \"zip\"\n"), HasSubstr("quantized"));
  EXPECT_THAT(refusal("range = \"5:0.4\"\n"), HasSubstr("below FAR"));
  EXPECT_THAT(refusal("depth-qp = 12\ndepth-kbps = 1500\n"),
              HasSubstr("desk.toml:2: depth-kbps and depth-qp"));
  EXPECT_THAT(refusal("= 12\n"), HasSubstr("desk.toml:1: "));
  for (const char* no_key : {"config", "list", "help", "version"}) {
    EXPECT_THAT(refusal(std::string(no_key) + " = true\n"), HasSubstr("there is no setting")) << no_key;
  }
}

TEST(Settings, AFileThatIsNotThereIsRefused) {
  const Arguments arguments{"capture_server", "--source", "desk.oni", "--config", "/nowhere/desk.toml"};
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(read_command_line(static_cast<int>(arguments.size()), arguments.data()).error(), 2);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("/nowhere/desk.toml"));
}

TEST(Settings, AreReadAgainFromTheFileAsItIsThen) {
  SettingsFile file("source = \"desk.oni\"\ndepth-kbps = 4000\n");
  const Arguments arguments = file.with({"--color-kbps", "800"});
  const int count = static_cast<int>(arguments.size());
  EXPECT_EQ(settings_of(arguments).rates.depth_kbps, 4000);
  file.write("source = \"desk.oni\"\ndepth-qp = 24\ncolor-kbps = 3000\n");
  const auto again = read_again(count, arguments.data());
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->rates, (Rates{24, std::nullopt, 800}));
  file.write("source = \"desk.oni\"\ndepth-qp = 24\nspeed = 3\n");
  EXPECT_THAT(read_again(count, arguments.data()).error().what, HasSubstr("desk.toml:3: "));
  file.write("");
  EXPECT_THAT(read_again(count, arguments.data()).error().what, HasSubstr("--source"));
}

}  // namespace
}  // namespace copresence::server
