#include "common/scene/write_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace copresence::scene {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr std::string_view kLab = R"(# Our laboratory. Größe: 5 m
up = [0, -1, 0]   # as hung

# by the door
[[camera]]
name = "left"       # Kinect A00366
address = "127.0.0.1:7001"
width = 640
height = 480
fx = 585.0          # from the data sheet
fy = 585.0
cx = 320
cy = 240.0
world_from_camera = [[1,0,0,0],   # not yet
                     [0,1,0,0],
                     [0,0,1,0],
                     [0,0,0,1]]   # measured by hand
calibration_error_mm = 9   # guessed

[[camera]]
name = "right"
width = 640
height = 480
fx = 585.0
fy = 585.0
cx = 320
cy = 240
source = "takes/right.oni"

[clip]
min = [-2, -2, -2]
max = [2, 2, 2]     # the table's end
)";

const fs::path kPath = "room/scene.toml";

Scene lab() {
  return *parse(kLab, kPath);
}

std::string rewritten(std::string_view text, const Scene& scene) {
  const auto out = rewrite(text, scene, kPath);
  return out ? *out : out.error().what;
}

Rigid3 turned(double angle) {
  return {Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
          {0.1, -2.5, 1e-7}};
}

// Everything the file can say.
Scene full() {
  Scene scene = lab();
  scene.up = Eigen::Vector3d(0.1, -1, 0.2).normalized();
  scene.key = "keys/room.key";
  Camera& left = scene.cameras[0];
  left.model.fx = 579.123456789012345;
  left.model.distortion = {0.1, -0.2, 1e-4, -2e-5, 0.3, 0.15, 0, 7e-9};
  left.world_from_camera = turned(0.7);
  left.source = "openni:freenect://A00366";
  left.color = ColorCamera{left.model, turned(0.02)};
  left.color->model.width = 1280;
  left.color->model.fx = 1158.25;
  left.color->model.cx = 640;
  left.color_matching.emplace();
  *left.color_matching << 1.1f, 0, 0, -0.1f, 0, 0.9f, 0.05f, 0, 0, 0, 1, 1.0f / 3;
  left.calibration_error_mm = 4.2;
  return scene;
}

void expect_same(const Scene& a, const Scene& b) {
  EXPECT_TRUE(a.up.isApprox(b.up, 1e-15));
  EXPECT_EQ(a.key, b.key);
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (const Camera& camera : a.cameras) {
    SCOPED_TRACE(camera.name);
    const Camera* other = b.find(camera.name);
    ASSERT_TRUE(other);
    EXPECT_EQ(camera.address, other->address);
    EXPECT_EQ(camera.model, other->model);
    EXPECT_EQ(camera.source, other->source);
    ASSERT_EQ(camera.world_from_camera.has_value(), other->world_from_camera.has_value());
    if (camera.world_from_camera) {
      EXPECT_TRUE(camera.world_from_camera->matrix().isApprox(other->world_from_camera->matrix(), 1e-11));
    }
    ASSERT_EQ(camera.color.has_value(), other->color.has_value());
    if (camera.color) {
      EXPECT_EQ(camera.color->model, other->color->model);
      EXPECT_TRUE(
          camera.color->color_from_depth.matrix().isApprox(other->color->color_from_depth.matrix(), 1e-11));
    }
    EXPECT_EQ(camera.color_matching, other->color_matching);
    EXPECT_EQ(camera.calibration_error_mm, other->calibration_error_mm);
  }
  ASSERT_EQ(a.clip.has_value(), b.clip.has_value());
  if (a.clip) {
    EXPECT_TRUE(a.clip->min == b.clip->min && a.clip->max == b.clip->max);
  }
}

TEST(WriteScene, ReadsBackWhatItWrote) {
  for (const Scene& scene : {lab(), full()}) {
    const auto again = parse(to_toml(scene, kPath), kPath);
    ASSERT_TRUE(again) << again.error().what;
    expect_same(scene, *again);
  }
}

TEST(WriteScene, LeavesATextThatSaysItAllAsItIs) {
  EXPECT_EQ(rewritten(kLab, lab()), kLab);
}

TEST(WriteScene, ChangesOnlyWhatDiffers) {
  Scene scene = lab();
  scene.cameras[0].model.fx = 579.5;
  scene.cameras[0].world_from_camera = Rigid3{Eigen::Matrix3d::Identity(), {0, 0, 1.5}};
  std::string expected(kLab);
  const std::string old_pose = R"([[1,0,0,0],   # not yet
                     [0,1,0,0],
                     [0,0,1,0],
                     [0,0,0,1]])";
  expected.replace(expected.find(old_pose), old_pose.size(),
                   "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1.5], [0, 0, 0, 1]]");
  expected.replace(expected.find("585.0 "), 6, "579.5 ");
  EXPECT_EQ(rewritten(kLab, scene), expected);
}

TEST(WriteScene, PutsNewKeysAfterTheirNeighboursAndTakesOldOnesOut) {
  Scene scene = lab();
  scene.cameras[0].calibration_error_mm.reset();
  scene.cameras[1].world_from_camera = Rigid3{};
  scene.cameras[1].calibration_error_mm = 3;
  const std::string text = rewritten(kLab, scene);
  EXPECT_THAT(text, Not(HasSubstr("guessed")));
  EXPECT_THAT(
      text,
      HasSubstr("cy = 240\nworld_from_camera = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
                "source = \"takes/right.oni\"\ncalibration_error_mm = 3.0\n\n[clip]"));
}

TEST(WriteScene, KeepsCommentsWhenEverythingChanges) {
  const std::string text = rewritten(kLab, full());
  for (const char* comment :
       {"# Our laboratory. Größe: 5 m", "# as hung", "# by the door", "# Kinect A00366",
        "# from the data sheet", "# measured by hand", "# guessed", "# the table's end"}) {
    EXPECT_THAT(text, HasSubstr(comment));
  }
  const auto again = parse(text, kPath);
  ASSERT_TRUE(again) << again.error().what;
  expect_same(full(), *again);
}

TEST(WriteScene, AddsAndRemovesCamerasAndTheClip) {
  Scene scene = full();
  scene.cameras[1].name = "third \"\\ \t é";  // right goes, this one comes
  scene.clip.reset();
  std::string text = rewritten(kLab, scene);
  EXPECT_THAT(text, HasSubstr("# by the door"));
  EXPECT_THAT(text, Not(HasSubstr("[clip]")));
  auto again = parse(text, kPath);
  ASSERT_TRUE(again) << again.error().what;
  expect_same(scene, *again);

  text = rewritten(text, lab());  // and back
  again = parse(text, kPath);
  ASSERT_TRUE(again) << again.error().what;
  expect_same(lab(), *again);
  EXPECT_THAT(text, HasSubstr("# by the door"));
}

TEST(WriteScene, AddsTheWorldsUpAboveTheFirstTable) {
  std::string text(kLab.substr(kLab.find("# by the door")));
  Scene scene = lab();
  scene.up = {0, 0, 1};
  text = rewritten(text, scene);
  EXPECT_THAT(text, StartsWith("up = [0.0, 0.0, 1.0]\n# by the door\n[[camera]]"));
}

TEST(WriteScene, WritesFormsItCannotChangeInPlaceAnew) {
  const std::string text =
      "camera = [{ name = \"a\", width = 64, height = 48, fx = 60, fy = 60, cx = 32, cy = 24 }]  # short\n";
  const auto read = parse(text, kPath);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(rewritten(text, *read), text);
  Scene scene = *read;
  scene.cameras[0].world_from_camera = turned(1);
  const std::string out = rewritten(text, scene);
  EXPECT_THAT(out, HasSubstr("[[camera]]\nname = \"a\""));
  expect_same(scene, *parse(out, kPath));
}

TEST(WriteScene, TakesATextWithoutALastNewline) {
  std::string text(kLab.substr(0, kLab.find("\n\n[clip]")));
  Scene scene = lab();
  scene.cameras[1].calibration_error_mm = 3;
  const auto again = parse(rewritten(text, scene), kPath);
  ASSERT_TRUE(again) << again.error().what;
  expect_same(scene, *again);
}

TEST(WriteScene, NamesRecordingsRelativeToTheFileWhereverItLies) {
  Scene scene = lab();
  EXPECT_THAT(to_toml(scene, "room/scene.toml"), HasSubstr("source = \"takes/right.oni\""));
  EXPECT_THAT(to_toml(scene, "out/scene.toml"), HasSubstr("source = \"../room/takes/right.oni\""));
  EXPECT_THAT(*rewrite(kLab, scene, "scene.toml"), HasSubstr("source = \"room/takes/right.oni\""));
  scene.cameras[1].source = "/data/right.oni";
  EXPECT_THAT(to_toml(scene, "out/scene.toml"), HasSubstr("source = \"/data/right.oni\""));
}

TEST(WriteScene, AddsChangesAndRemovesTheKeyAndNothingElse) {
  Scene scene = lab();
  scene.key = "room/room.key";
  const std::string with_key = rewritten(kLab, scene);
  EXPECT_EQ(with_key, "key = \"room.key\"\n" + std::string(kLab));
  scene.key = "/etc/copresence/room.key";
  EXPECT_EQ(rewritten(with_key, scene), "key = \"/etc/copresence/room.key\"\n" + std::string(kLab));
  scene.key.clear();
  EXPECT_EQ(rewritten(with_key, scene), kLab);
}

TEST(WriteScene, RefusesToRewriteWhatIsNoSceneFile) {
  EXPECT_THAT(rewritten("up = [0, 1", lab()), StartsWith("room/scene.toml:1:"));
  EXPECT_THAT(rewritten("floor = 1\n", lab()), StartsWith("room/scene.toml:1: unknown key"));
}

class SaveScene : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  static std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path folder_ = fs::temp_directory_path() / ("copresence_scene_" + std::to_string(getpid()));
};

TEST_F(SaveScene, ReplacesAFileAndKeepsItsComments) {
  const fs::path file = folder_ / "scene.toml";
  std::ofstream(file) << kLab;
  auto scene = load(file);
  ASSERT_TRUE(scene) << scene.error().what;
  scene->cameras[0].model.fx = 500;
  ASSERT_TRUE(save(*scene, file, file));
  EXPECT_THAT(text_of(file), HasSubstr("fx = 500.0          # from the data sheet"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);  // nothing unfinished is left
}

TEST_F(SaveScene, FollowsALinkAndKeepsWhoMayRead) {
  const fs::path file = folder_ / "shared.toml", link = folder_ / "scene.toml";
  std::ofstream(file) << kLab;
  constexpr auto kGroup =
      fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read | fs::perms::group_write;
  fs::permissions(file, kGroup);
  fs::create_symlink("shared.toml", link);
  auto scene = load(link);
  ASSERT_TRUE(scene) << scene.error().what;
  scene->cameras[0].model.fx = 500;
  ASSERT_TRUE(save(*scene, link, link));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_THAT(text_of(file), HasSubstr("fx = 500.0"));
  EXPECT_EQ(fs::status(file).permissions(), kGroup);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(SaveScene, KeepsTheOldFileWhereTheNewOneCouldNotBeReadAgain) {
  const fs::path file = folder_ / "scene.toml";
  std::ofstream(file) << kLab;
  for (const std::string name : {"k\xfc\x63he", "", "\xc3"}) {  // Latin-1, empty, half a character
    Scene scene = lab();
    scene.cameras[0].name = name;
    const auto saved = save(scene, file, file);
    ASSERT_FALSE(saved) << name;
    EXPECT_EQ(saved.error().code, ErrorCode::kInvalid);
    EXPECT_THAT(saved.error().what, HasSubstr("scene.toml: is not written"));
    EXPECT_EQ(text_of(file), kLab);
    EXPECT_FALSE(save(scene, folder_ / "new.toml", ""));
    EXPECT_FALSE(fs::exists(folder_ / "new.toml"));
  }
}

TEST_F(SaveScene, WritesANewFileAndSaysWhereItCannot) {
  ASSERT_TRUE(save(lab(), folder_ / "new.toml", folder_ / "nothing.toml"));
  EXPECT_TRUE(load(folder_ / "new.toml"));
  const auto nowhere = save(lab(), folder_ / "no/such/new.toml", "");
  ASSERT_FALSE(nowhere);
  EXPECT_THAT(nowhere.error().what, HasSubstr("no/such/new.toml: cannot be written"));
  std::ofstream(folder_ / "bad.toml") << "camera = 3\n";
  EXPECT_EQ(save(lab(), folder_ / "out.toml", folder_ / "bad.toml").error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace copresence::scene
