#include "common/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::scene {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr std::string_view kLeft = R"(
[[camera]]
name = "left"
address = "127.0.0.1:7001"
width = 640
height = 480
fx = 585.0
fy = 585.0
cx = 320
cy = 240.0
world_from_camera = [[0,-1,0,0.5],[1,0,0,0],[0,0,1,-2],[0,0,0,1]]
)";

Result<Scene> parsed(const std::string& text) {
  return parse(text, "room/scene.toml");
}

std::string error_of(const std::string& text) {
  const auto scene = parsed(text);
  return scene ? "no error" : scene.error().what;
}

std::string left_with(const std::string& line) {
  return std::string(kLeft) + line + "\n";
}

TEST(Scene, ReadsACamera) {
  const auto scene = parsed(std::string(kLeft));
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_EQ(scene->cameras.size(), 1u);
  const Camera& left = scene->cameras[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.address, "127.0.0.1:7001");
  EXPECT_EQ(left.model.width, 640);
  EXPECT_EQ(left.model.cx, 320);
  EXPECT_FALSE(left.model.is_distorted());
  EXPECT_TRUE((*left.world_from_camera * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0.5, 1, -2)));
  EXPECT_FALSE(left.color || left.color_matching || left.calibration_error_mm || scene->clip);
  EXPECT_EQ(scene->up, Eigen::Vector3d(0, -1, 0));
}

TEST(Scene, ReadsEverythingOptional) {
  const auto scene = parsed("up = [0, 0, 2]\n" + left_with(R"(
distortion = [0.1, -0.2]
source = "recordings/left.oni"
color = { width = 640, height = 480, fx = 525, fy = 525, cx = 320, cy = 240, distortion = [], color_from_depth = [[1,0,0,0.025],[0,1,0,0],[0,0,1,0],[0,0,0,1]] }
color_matching = [[1.1,0,0,0],[0,1,0,0],[0,0,1,-0.1]]
calibration_error_mm = 4.2
[clip]
min = [-2, -2, -2]
max = [2, 2, 2])"));
  ASSERT_TRUE(scene) << scene.error().what;
  const Camera& left = scene->cameras[0];
  EXPECT_EQ(scene->up, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(left.model.distortion[1], -0.2);
  EXPECT_EQ(left.source, "room/recordings/left.oni");
  EXPECT_EQ(left.color->color_from_depth.translation.x(), 0.025);
  EXPECT_FLOAT_EQ((*left.color_matching)(2, 3), -0.1f);
  EXPECT_EQ(left.calibration_error_mm, 4.2);
  EXPECT_EQ(scene->clip->max, Eigen::Vector3d(2, 2, 2));
}

TEST(Scene, TakesAnUpOfAnyLength) {
  for (const char* up : {"[0, 0, 1.7e308]", "[0, 0, 1e-8]"}) {
    const auto scene = parsed("up = " + std::string(up) + "\n" + std::string(kLeft));
    ASSERT_TRUE(scene) << scene.error().what;
    EXPECT_EQ(scene->up, Eigen::Vector3d(0, 0, 1)) << up;
  }
}

TEST(Scene, LeavesDevicesAndAbsolutePathsAlone) {
  EXPECT_EQ(parsed(left_with("source = \"openni:freenect://A00366\""))->cameras[0].source,
            "openni:freenect://A00366");
  EXPECT_EQ(parsed(left_with("source = \"/data/left.oni\""))->cameras[0].source, "/data/left.oni");
}

TEST(Scene, TakesAPoseWrittenWithFewDigitsAsTheNearestRotation) {
  std::string text(kLeft);
  const std::string exact = "[[0,-1,0,0.5],[1,0,0,0],";
  text.replace(text.find(exact), exact.size(), "[[0.001,-0.999,0,0.5],[1.001,0.001,0,0],");
  const auto scene = parsed(text);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_TRUE(scene->cameras[0].world_from_camera->is_rigid(1e-12));
}

TEST(Scene, FindsACameraByName) {
  const auto scene = parsed(std::string(kLeft));
  EXPECT_EQ(scene->find("left"), &scene->cameras[0]);
  EXPECT_EQ(scene->find("right"), nullptr);
}

TEST(Scene, NamesFileAndLineOfWhatIsWrong) {
  EXPECT_THAT(error_of("up = [0, 1\n"), StartsWith("room/scene.toml:"));
  EXPECT_THAT(error_of(left_with("colour = 3")), StartsWith("room/scene.toml:12: unknown key \"colour\""));
  EXPECT_THAT(error_of("floor = 1\n" + std::string(kLeft)), StartsWith("room/scene.toml:1: unknown key"));
  EXPECT_THAT(error_of("up = [0, 0, 0]\n" + std::string(kLeft)), HasSubstr("must not be zero"));
  EXPECT_THAT(error_of("up = [0, \"a\", 0]\n" + std::string(kLeft)), HasSubstr("finite number"));
  EXPECT_THAT(error_of(left_with("calibration_error_mm = -1")), HasSubstr("scene.toml:12:"));
  EXPECT_THAT(error_of(left_with("distortion = [1,2,3,4,5,6,7,8,9]")), HasSubstr("up to eight"));
  EXPECT_THAT(error_of(left_with("color = 5")), HasSubstr("must be a table"));
  EXPECT_THAT(error_of(left_with("[clip]\nmin = [0,0,0]\nmax = [1,0,1]")), HasSubstr("below"));
  EXPECT_THAT(error_of(std::string(kLeft) + std::string(kLeft)), HasSubstr("second camera"));
  EXPECT_THAT(error_of(""), HasSubstr("no [[camera]]"));
}

TEST(Scene, RefusesCamerasThatCannotBe) {
  const auto replaced = [](std::string from, std::string to) {
    std::string text(kLeft);
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(error_of(replaced("width = 640", "width = 641")), HasSubstr("must be even"));
  EXPECT_THAT(error_of(replaced("fx = 585.0", "fx = -585.0")), HasSubstr("positive focal"));
  EXPECT_THAT(error_of(replaced("fy = 585.0", "fy = nan")), HasSubstr("finite"));
  EXPECT_THAT(error_of(replaced("cy = 240.0", "")), HasSubstr("\"cy\" is missing"));
  EXPECT_THAT(error_of(replaced("[0,-1,0,0.5]", "[0,-2,0,0.5]")), HasSubstr("not a rigid transform"));
  for (const char* far : {"[0,-1,0,20000]", "[0,-1,0,-1.7e308]"})
    EXPECT_THAT(error_of(replaced("[0,-1,0,0.5]", far)), HasSubstr("10000 m away from the origin"));
  EXPECT_THAT(error_of(replaced("[0,-1,0,0.5]", "[0,-1,0]")), HasSubstr("4 numbers"));
  EXPECT_THAT(error_of(replaced("name = \"left\"", "name = \"\"")), HasSubstr("needs a \"name\""));
  EXPECT_THAT(error_of(replaced("name = \"left\"", "name = 3")), HasSubstr("text in quotes"));
}

std::string repeated(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

// Each overflowed the stack of the program that read it, or would where a string's end is misjudged.
TEST(Scene, RefusesTextsThatNestWithoutEndByTheirLine) {
  constexpr int kTimes = 100'000;
  const std::string deep = repeated("a.", kTimes) + "a";
  for (const std::string& text :
       {"[" + deep + "]\n", "[[" + deep + "]]\n", deep + " = 1\n", repeated("\"a\" . ", kTimes) + "a = 1\n",
        repeated("'a'.", kTimes) + "a = 1\n", "up = { " + deep + " = 1 }\n",
        "up = " + repeated("[", kTimes) + "\n", "up = " + repeated("{a=", kTimes) + "\n",
        "up = {b = \"\"\"x\"\"\"\"\", " + deep + " = 1}\n", "up = {b = '''x''''', " + deep + " = 1}\n",
        "up = {b = \"\\\"\", " + deep + " = 1}\n"}) {
    const std::string what = error_of("# lines before it\n\n" + text);
    EXPECT_THAT(what, StartsWith("room/scene.toml:3: ")) << text.substr(0, 40);
    EXPECT_THAT(what, HasSubstr("16 levels")) << text.substr(0, 40);
  }
}

TEST(Scene, IsNotTooDeepForWhatStandsInStringsAndComments) {
  const std::string dots = repeated("a.[{", 100);
  for (const std::string& quoted :
       {"\"" + dots + "\"", "'" + dots + "'", "\"\"\"" + dots + "\n\"" + dots + "\"\"\""}) {
    const auto scene = parsed("# " + dots + "\n" + left_with("source = " + quoted));
    EXPECT_TRUE(scene) << scene.error().what;
  }
}

TEST(Scene, SaysWhatIsWrongInAShortSentence) {
  const std::string huge(400'000, 'h');
  for (const std::string& text :
       {huge + " = 1\n", "[" + huge + "]\n", huge + huge.substr(1), "a = \"" + huge + "\" b\n",
        left_with("source = \"" + huge + "\""), left_with(huge + " = 1"), "[clip]\n" + huge + " = [1]\n",
        "[[camera]]\nname = \"" + huge + "\"\n", left_with("address = \"" + huge + "\"")}) {
    EXPECT_LT(error_of(text).size(), 600u);
    EXPECT_THAT(error_of(text), StartsWith("room/scene.toml:"));
  }
  EXPECT_THAT(error_of(std::string(2'000'000, '\n')), HasSubstr("larger than 1024 kB"));
}

TEST(Scene, SaysThatAFileIsMissing) {
  EXPECT_THAT(load("/nowhere/scene.toml").error().what, HasSubstr("there is no file /nowhere/scene.toml"));
  EXPECT_FALSE(load("/"));
}

}  // namespace
}  // namespace copresence::scene
