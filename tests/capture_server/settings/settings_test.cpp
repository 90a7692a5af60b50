#include "capture_server/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

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

/// Returns the error message for a file.
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
      "\"median\"\ntemporal-filter = \"off\"\n"
      "insecure = true\nloop = false\n");
  const ServerSettings settings = settings_of(file.with());
  EXPECT_EQ(settings.source, "openni:");
  EXPECT_EQ(settings.name, "left");
  EXPECT_EQ(settings.encoder.depth_kbps, 1500);
  EXPECT_EQ(settings.range.near_m, 0.5);
  EXPECT_EQ(settings.hole_filling, hole_filling::Method::kMedian);
  EXPECT_EQ(settings.temporal_filter, temporal_filter::Mode::kOff);
  EXPECT_TRUE(settings.insecure);
  EXPECT_FALSE(settings.loop);
  EXPECT_EQ(settings.codec, "adaptive");  // The default.

  const ServerSettings over = settings_of(file.with({"--name", "right", "--depth-kbps", "900"}));
  EXPECT_EQ(over.name, "right");
  EXPECT_EQ(over.encoder.depth_kbps, 900);
  EXPECT_EQ(over.source, "openni:");
}

TEST(Settings, OfTheFileGiveWayToTheirOppositeOnTheCommandLine) {
  SettingsFile file("depth-kbps = 1500\n");
  const ServerSettings settings = settings_of(file.with({"--source", "desk.oni", "--depth-qp", "12"}));
  EXPECT_EQ(settings.encoder.depth_qp, 12);
  EXPECT_EQ(settings.encoder.depth_kbps, std::nullopt);
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
  SettingsFile file(
      "source = \"desk.oni\"\nscene = \"room/scene.toml\"\nrecord = \"/tmp/x.oni\"\nkey = \"room.key\"\n"
      "listen = \"127.0.0.1:7009\"\n");
  const ServerSettings settings = settings_of(file.with());
  EXPECT_EQ(settings.source, file.in_folder("desk.oni"));
  EXPECT_EQ(settings.scene, file.in_folder("room/scene.toml"));
  EXPECT_EQ(settings.record, "/tmp/x.oni");
  EXPECT_EQ(settings.key, file.in_folder("room.key"));
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

TEST(Settings, NameAHugeKeyInAShortSentence) {
  EXPECT_LT(refusal(std::string(500'000, 'k') + " = 1\n").size(), 600u);
  EXPECT_LT(refusal("range = \"" + std::string(500'000, '1') + "\"\n").size(), 2000u);
}

TEST(Settings, AKeyAndInsecureExcludeEachOther) {
  EXPECT_THAT(refusal("insecure = true\nkey = \"room.key\"\n"),
              HasSubstr("key and insecure exclude each other"));
  SettingsFile file("insecure = true\nsource = \"desk.oni\"\n");
  const ServerSettings settings = settings_of(file.with({"--key", "room.key"}));
  EXPECT_FALSE(settings.insecure) << "the command line has priority";
  EXPECT_EQ(settings.key, "room.key");
}

TEST(Settings, MakingAKeyNeedsNothingElse) {
  EXPECT_EQ(settings_of({"capture_server", "--make-key", "room.key"}).make_key, "room.key");
}

constexpr const char* kLens = "width = 640\nheight = 480\nfx = 585\nfy = 585\ncx = 320\ncy = 240\n";

/// A scene file of two cameras, and a settings file that refers to it.
class SettingsOfAScene : public ::testing::Test {
 protected:
  SettingsOfAScene() {
    write_scene(
        std::string("[[camera]]\nname = \"left\"\naddress = \"127.0.0.1:7011\"\nsource = \"left.oni\"\n") +
        kLens + "[[camera]]\nname = \"right\"\nsource = \"simulated:room?camera=1\"\n" + kLens);
  }
  void write_scene(const std::string& text) const { std::ofstream(scene_) << text; }
  /// Exit code and output.
  std::pair<int, std::string> refusal_of(std::vector<const char*> more) const {
    more.insert(more.begin(), {"capture_server", "--scene", scene_.c_str()});
    ::testing::internal::CaptureStderr();
    const auto settings = read_command_line(static_cast<int>(more.size()), more.data());
    const std::string said = ::testing::internal::GetCapturedStderr();
    return {settings ? 0 : settings.error(), said};
  }
  ServerSettings given(std::vector<const char*> more) const {
    more.insert(more.begin(), {"capture_server", "--scene", scene_.c_str()});
    return settings_of(more);
  }

  SettingsFile file_{""};
  std::string scene_ = file_.in_folder("scene.toml");
};

TEST_F(SettingsOfAScene, TakeSourceAndAddressFromItsCamera) {
  const ServerSettings left = given({"--name", "left"});
  EXPECT_EQ(left.source, file_.in_folder("left.oni"));
  EXPECT_EQ(left.listen, "127.0.0.1:7011");
  EXPECT_EQ(left.texts.at("source"), left.source);
  const ServerSettings right = given({"--name", "right"});
  EXPECT_EQ(right.source, "simulated:room?camera=1");
  EXPECT_EQ(right.listen, "127.0.0.1:7001");  // The file has no address, so this is the default.
}

TEST_F(SettingsOfAScene, GiveWayToTheCommandLineAndTheSettingsFile) {
  const ServerSettings settings =
      given({"--name", "left", "--source", "openni:", "--listen", "127.0.0.1:7012"});
  EXPECT_EQ(settings.source, "openni:");
  EXPECT_EQ(settings.listen, "127.0.0.1:7012");
  file_.write("listen = \"127.0.0.1:7013\"\nname = \"left\"\nscene = \"scene.toml\"\n");
  const ServerSettings from_file = settings_of(file_.with());
  EXPECT_EQ(from_file.listen, "127.0.0.1:7013");
  EXPECT_EQ(from_file.source, file_.in_folder("left.oni"));
}

TEST_F(SettingsOfAScene, NeedNoNameWhereThereIsOneCamera) {
  write_scene(std::string("[[camera]]\nname = \"only\"\nsource = \"openni:\"\n") + kLens);
  EXPECT_EQ(given({}).name, "only");
  EXPECT_EQ(given({}).source, "openni:");
}

TEST_F(SettingsOfAScene, SayWhatTheFileDoesNotTell) {
  EXPECT_THAT(refusal_of({}), ::testing::Pair(2, HasSubstr("choose one with --name: left, right")));
  EXPECT_THAT(refusal_of({"--name", "middle"}), ::testing::Pair(1, HasSubstr("its cameras are left, right")));
  write_scene(std::string("[[camera]]\nname = \"left\"\n") + kLens);
  EXPECT_THAT(refusal_of({"--name", "left"}),
              ::testing::Pair(2, HasSubstr("no \"source\" for camera \"left\"")));
  write_scene("[[camera]]\nname = 3\n");
  EXPECT_THAT(refusal_of({"--name", "left"}), ::testing::Pair(1, HasSubstr("scene.toml:")));
  std::filesystem::remove(scene_);
  EXPECT_THAT(refusal_of({"--name", "left"}), ::testing::Pair(1, HasSubstr("there is no file")));
}

TEST(Settings, AreReadAgainFromTheFileAsItIsThen) {
  SettingsFile file("source = \"desk.oni\"\ndepth-kbps = 4000\n");
  const Arguments arguments = file.with({"--color-kbps", "800"});
  const int count = static_cast<int>(arguments.size());
  EXPECT_EQ(settings_of(arguments).encoder.depth_kbps, 4000);
  file.write("source = \"desk.oni\"\ndepth-qp = 24\ncolor-kbps = 3000\n");
  const auto again = read_again(count, arguments.data());
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->encoder, (EncoderSettings{24, std::nullopt, 800}));
  file.write("source = \"desk.oni\"\ndepth-qp = 24\nspeed = 3\n");
  EXPECT_THAT(read_again(count, arguments.data()).error().what, HasSubstr("desk.toml:3: "));
  file.write("");
  EXPECT_THAT(read_again(count, arguments.data()).error().what, HasSubstr("--source"));
}

TEST_F(SettingsOfAScene, TheKeyComesFromItUnlessTheCommandLineSaysOtherwise) {
  write_scene(std::string("key = \"room.key\"\n[[camera]]\nname = \"left\"\nsource = \"left.oni\"\n") +
              kLens);
  const std::string in_its_folder = file_.in_folder("room.key");
  EXPECT_EQ(given({}).key, in_its_folder);
  EXPECT_EQ(given({"--source", "openni:", "--listen", "127.0.0.1:7001"}).key, in_its_folder);
  EXPECT_EQ(given({"--key", "other.key"}).key, "other.key");
  EXPECT_EQ(given({"--insecure"}).key, "");
}

}  // namespace
}  // namespace copresence::server
