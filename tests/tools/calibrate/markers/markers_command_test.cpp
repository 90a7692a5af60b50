// Runs the program on recordings of the simulated world "markers", whose poses are known.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/scene/scene.h"
#include "simulation/scene/calibration_worlds.h"
#include "tests/support/process.h"

namespace copresence {
namespace {

using ::testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string said;
};

Outcome run(const std::vector<std::string>& arguments) {
  testing::Process process(arguments);
  const auto code = process.wait(std::chrono::seconds(60));
  return {code.value_or(-1), process.output()};
}

// Four Kinects and their true poses, recorded once for all tests.
class CalibrateMarkers : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new testing::TemporaryFolder;
    const Outcome made = run({testing::program("simulate_kinect"), "markers", "--cameras", "4", "--frames",
                              "8", "--out", (*folder_ / "room").string()});
    ASSERT_EQ(made.exit_code, 0) << made.said;
    truth_ = *scene::load(*folder_ / "room/scene.toml");
  }
  static void TearDownTestSuite() { delete folder_; }

  static Outcome calibrate(int cameras, std::vector<std::string> more) {
    std::vector<std::string> arguments{testing::program("calibrate"), "markers"};
    for (int c = 0; c < cameras; ++c) {
      const std::string name = "camera" + std::to_string(c);
      arguments.push_back("--recording");
      arguments.push_back(name + "=" + (*folder_ / ("room/" + name + ".oni")).string());
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  // Shift in millimetres at the centre of the room, and rotation in degrees.
  static std::pair<double, double> error_of(const scene::Scene& scene, const std::string& name) {
    const Rigid3 off = *scene.find(name)->world_from_camera * truth_.find(name)->world_from_camera->inverse();
    const Eigen::Vector3d middle(0, -0.9, 0);
    return {1000 * (off * middle - middle).norm(),
            Eigen::AngleAxisd(off.rotation).angle() * 180 / std::numbers::pi};
  }

  static inline testing::TemporaryFolder* folder_ = nullptr;
  static inline scene::Scene truth_;
};

TEST_F(CalibrateMarkers, FindsFourCamerasFromTheirPictures) {
  const std::string out = (*folder_ / "four.toml").string(), json = (*folder_ / "four.json").string();
  const Outcome outcome = calibrate(4, {"--out", out, "--json", json});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  const auto scene = scene::load(out);
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_EQ(scene->cameras.size(), 4u);
  const auto report = nlohmann::json::parse(std::ifstream(json));
  for (int c = 0; c < 4; ++c) {
    const std::string name = "camera" + std::to_string(c);
    const auto [shift_mm, turn_deg] = error_of(*scene, name);
    std::printf("%s: off by %.2f mm, %.3f degrees; it expects %.2f mm\n", name.c_str(), shift_mm, turn_deg,
                report["cameras"][c]["expected_shift_mm"].get<double>());
    EXPECT_LT(shift_mm, 10) << name;
    EXPECT_LT(turn_deg, 0.3) << name;
    EXPECT_GE(report["cameras"][c]["markers"], c < 2 ? 8 : 7) << name;
    EXPECT_LT(report["cameras"][c]["rms_mm"], 15);
    EXPECT_EQ(scene->find(name)->source, (*folder_ / ("room/" + name + ".oni")).string());
    ASSERT_TRUE(scene->find(name)->calibration_error_mm);
  }
  for (const auto& marker : report["markers"]) {
    const simulation::PlacedMarker placed =
        simulation::placed_markers()[std::stoul(marker["name"].get<std::string>())];
    const Eigen::Vector3d there(marker["world"][0], marker["world"][1], marker["world"][2]);
    EXPECT_LT((there - placed.center.cast<double>()).norm(), 0.015) << marker["name"];
  }
  EXPECT_THAT(outcome.said, HasSubstr("reference"));
}

TEST_F(CalibrateMarkers, ReportsTheLinearFormBesideTheRigidOneAndSolvesByItWhenAsked) {
  const std::string out = (*folder_ / "linear.toml").string(), json = (*folder_ / "linear.json").string();
  const Outcome outcome = calibrate(2, {"--solver", "linear", "--out", out, "--json", json});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  const auto report = nlohmann::json::parse(std::ifstream(json));
  EXPECT_EQ(report["solver"], "linear");
  EXPECT_LT(report["pairs"][0]["linear_rms_mm"], 15);
  EXPECT_LT(report["pairs"][0]["rigid_rms_mm"], 15);
  EXPECT_LT(error_of(*scene::load(out), "camera1").first, 40);
}

// Clicks on six markers. In camera1 the first `swapped` of them are in the opposite order.
void write_clicks(const std::string& path, const scene::Scene& truth, int swapped) {
  std::ofstream file(path);
  for (const char* name : {"camera0", "camera1"}) {
    const scene::Camera& camera = *truth.find(name);
    for (int number = 0; number < 6; ++number) {
      const bool swap = camera.name == "camera1" && number < swapped;
      const auto id = static_cast<std::size_t>(swap ? swapped - 1 - number : number);
      const Eigen::Vector3d center = simulation::placed_markers()[id].center.cast<double>();
      const Eigen::Vector2d pixel = project(camera.model, camera.world_from_camera->inverse() * center);
      file << name << " point" << number << " " << std::lround(pixel.x()) << " " << std::lround(pixel.y())
           << "\n";
    }
  }
}

TEST_F(CalibrateMarkers, TakesPointsFromAFile) {
  const std::string points = (*folder_ / "points.txt").string(), out = (*folder_ / "clicked.toml").string();
  write_clicks(points, truth_, 0);
  const Outcome outcome = calibrate(2, {"--points", points, "--dictionary", "apriltag_36h11", "--out", out});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  EXPECT_THAT(outcome.said, HasSubstr("point5"));
  EXPECT_LT(error_of(*scene::load(out), "camera1").first, 15);
}

TEST_F(CalibrateMarkers, RefusesMarkersThatWereClickedInTheWrongOrder) {
  const std::string points = (*folder_ / "swapped.txt").string(), out = (*folder_ / "swapped.toml").string();
  write_clicks(points, truth_, 2);
  const Outcome outcome = calibrate(2, {"--points", points, "--dictionary", "apriltag_36h11", "--out", out});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("away from where all cameras together put it"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(CalibrateMarkers, PointsOfACameraThatIsNotThereAreNotForgotten) {
  const std::string points = (*folder_ / "other.txt").string();
  std::ofstream(points) << "camera7 point1 10 20\n";
  const Outcome outcome = calibrate(2, {"--points", points});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("has points of camera \"camera7\", but no --recording or --stream"));
}

TEST_F(CalibrateMarkers, ClickingWithoutADisplayIsASentence) {
  unsetenv("WAYLAND_DISPLAY");
  setenv("DISPLAY", ":4999", 1);  // does not exist
  const Outcome outcome = calibrate(2, {"--click"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("no window can be opened to click in"));
}

TEST_F(CalibrateMarkers, StartsFromASceneFileAndKeepsItsComments) {
  const std::string out = (*folder_ / "kept.toml").string();
  std::ofstream(out) << std::ifstream(*folder_ / "room/scene.toml").rdbuf() << "# the lab's own words\n";
  const Outcome outcome = calibrate(2, {"--scene", out, "--out", out, "--reference", "camera1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  const auto scene = scene::load(out);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->cameras.size(), 4u);
  EXPECT_LT(error_of(*scene, "camera1").first, 1e-6);
  EXPECT_LT(error_of(*scene, "camera0").first, 10);
  EXPECT_EQ(scene->find("camera0")->address, "127.0.0.1:7001");
  std::ifstream again(out);
  const std::string text{std::istreambuf_iterator<char>(again), {}};
  EXPECT_THAT(text, HasSubstr("# the lab's own words"));
  EXPECT_THAT(text, HasSubstr("# Made by: simulate_kinect"));
}

class CalibrateChessboard : public ::testing::Test {
 protected:
  static Outcome calibrate(const std::vector<std::string>& more) {
    const testing::TemporaryFolder folder;
    return calibrate(folder, more);
  }
  static Outcome calibrate(const testing::TemporaryFolder& folder, const std::vector<std::string>& more) {
    const std::string room = (folder / "room").string();
    const Outcome made = run({testing::program("simulate_kinect"), "still-board", "--cameras", "2",
                              "--frames", "4", "--out", room});
    EXPECT_EQ(made.exit_code, 0) << made.said;
    std::vector<std::string> arguments{
        testing::program("calibrate"),      "markers",     "--recording",
        "camera0=" + room + "/camera0.oni", "--recording", "camera1=" + room + "/camera1.oni"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
};

TEST_F(CalibrateChessboard, PlacesTwoCamerasThatSeeOneBoard) {
  const testing::TemporaryFolder folder;
  const std::string out = (folder / "pair.toml").string();
  const Outcome outcome = calibrate(folder, {"--chessboard", "9x6", "--square", "90", "--out", out});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  EXPECT_THAT(outcome.said, HasSubstr("corners"));
  EXPECT_LT(std::count(outcome.said.begin(), outcome.said.end(), '\n'), 12) << "not a line for each corner";
  const auto found = scene::load(out), truth = scene::load(folder / "room/scene.toml");
  ASSERT_TRUE(found && truth);
  const Rigid3 off =
      *found->find("camera1")->world_from_camera * truth->find("camera1")->world_from_camera->inverse();
  const Eigen::Vector3d middle(0, -1, 0);
  EXPECT_LT(1000 * (off * middle - middle).norm(), 5);
  EXPECT_LT(Eigen::AngleAxisd(off.rotation).angle() * 180 / std::numbers::pi, 0.4);
}

TEST_F(CalibrateChessboard, AWrongSizeOfTheSquaresShowsInDepth) {
  const Outcome outcome = calibrate({"--chessboard", "9x6", "--square", "45"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("as of squares of 90 mm: measure them and give --square"));
}

TEST_F(CalibrateChessboard, AnotherNumberOfCornersIsAskedFor) {
  const Outcome outcome = calibrate({"--chessboard", "7x6", "--square", "90"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("is its size in inner corners as given?"));
}

TEST_F(CalibrateMarkers, SaysWhatIsMissing) {
  const Outcome none = calibrate(2, {"--dictionary", "6x6_250"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.said, HasSubstr("shows 0 markers of 6x6_250, but "));
  EXPECT_THAT(none.said, HasSubstr("markers of 4x4_50: give --dictionary 4x4_50"));
  EXPECT_EQ(calibrate(2, {"--reference", "camera9"}).exit_code, 1);
  EXPECT_EQ(calibrate(0, {}).exit_code, 2);
  EXPECT_EQ(calibrate(2, {"--solver", "magic"}).exit_code, 2);
  EXPECT_EQ(run({testing::program("calibrate"), "markers", "--recording", "camera0"}).exit_code, 2);
  const Outcome gone = run({testing::program("calibrate"), "markers", "--recording", "a=/nowhere.oni",
                            "--recording", "b=/nowhere.oni"});
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.said, HasSubstr("/nowhere.oni"));
}

}  // namespace
}  // namespace copresence
