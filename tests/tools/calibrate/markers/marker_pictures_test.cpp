// Tests of markers in pictures, of clicks, and of the pose between a sensor's two cameras.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <Eigen/Geometry>

#include <filesystem>
#include <fstream>

#include "common/frame/rgbd_frame.h"
#include "tests/tools/calibrate/painted_planes.h"
#include "tools/calibrate/markers/clicks.h"
#include "tools/calibrate/markers/depth_to_color.h"
#include "tools/calibrate/markers/marker_finder.h"

namespace copresence::calibrate {
namespace {

using testing::HasSubstr;

Rigid3 at(double x, double y, double z) {
  return {Eigen::Matrix3d::Identity(), {x, y, z}};
}

const CameraModel kDepthIntrinsics{320, 240, 290, 290, 160, 120, {}};
const CameraModel kColorIntrinsics{640, 480, 525, 526, 318, 242, {0.08, -0.1, 0.001, 0, 0, 0, 0, 0}};
const Rigid3 kColorFromDepth{
    Eigen::AngleAxisd(0.012, Eigen::Vector3d(1, 2, 0).normalized()).toRotationMatrix(),
    {-0.025, 0.001, -0.003}};

TEST(MarkerFinder, FindsMiddlesToAThirdOfAPixelThroughALens) {
  auto finder = MarkerFinder::open("4x4_50");
  ASSERT_TRUE(finder);
  finder->add(PaintedCamera(kColorIntrinsics).picture(painted_markers(kColorFromDepth)));
  const auto found = finder->found(kColorIntrinsics);
  ASSERT_EQ(found.size(), marker_places().size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].name, std::to_string(i));
    const Rigid3 place = kColorFromDepth * marker_places()[i];
    EXPECT_LT((found[i].middle - project(kColorIntrinsics, place.translation)).norm(), 0.3) << i;
    const Eigen::Vector3d corner = place * Eigen::Vector3d(-kMarkerSize / 2, -kMarkerSize / 2, 0);
    EXPECT_LT((found[i].corners[0] - project(kColorIntrinsics, corner)).norm(), 0.6) << i;
  }
}

TEST(MarkerFinder, LeavesOutWhatMovesOrIsSeldomSeen) {
  const PaintedCamera camera(kDepthIntrinsics);
  auto finder = MarkerFinder::open("4x4_50");
  for (int picture = 0; picture < 4; ++picture) {
    std::vector<PaintedPlane> scene{painted_marker(1, at(-0.3, 0, 1.3)),
                                    painted_marker(2, at(0.3, 0.05 * picture, 1.3))};
    if (picture == 0) scene.push_back(painted_marker(3, at(0, -0.35, 1.4)));
    finder->add(camera.picture(scene));
  }
  const auto found = finder->found(kDepthIntrinsics);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].name, "1");
  EXPECT_EQ(finder->moved(), std::vector<std::string>{"2"});
  EXPECT_FALSE(MarkerFinder::open("9x9_1"));
}

Result<DepthToColor> fit_depth_to_color(const RgbdFrame& frame) {
  auto finder = DepthToColorFinder::open(DepthUnit::kMillimetre, "4x4_50", 1);
  if (!finder) return fail(finder.error());
  finder->add_depth(frame.depth);
  finder->add_color(*frame.color);
  return finder->fit(kDepthIntrinsics, kColorIntrinsics);
}

TEST(DepthToColor, FindsTheTransformFromMarkersThatReturnNoDepthWhereTheyAreDark) {
  RgbdFrame frame;
  frame.depth = PaintedCamera(kDepthIntrinsics).depth(painted_markers(Rigid3{}));
  frame.color = PaintedCamera(kColorIntrinsics).picture(painted_markers(kColorFromDepth));
  const auto fit = fit_depth_to_color(frame);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_EQ(fit->markers, 5);
  EXPECT_LT(fit->rms_px, 1.5);
  EXPECT_LT((fit->color_from_depth.translation - kColorFromDepth.translation).norm(), 0.006);
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0.4, 0.3, 1.2), Eigen::Vector3d(-0.4, -0.2, 1.6), Eigen::Vector3d(0, 0, 1.4)}) {
    const Eigen::Vector2d there = project(kColorIntrinsics, kColorFromDepth * point);
    EXPECT_LT((project(kColorIntrinsics, fit->color_from_depth * point) - there).norm(), 1.0);
  }
}

TEST(DepthToColor, SaysThatMarkersAreMissing) {
  RgbdFrame frame;
  frame.depth = DepthImage(320, 240, 1500);
  frame.color = PaintedCamera(kColorIntrinsics).picture(painted_markers(kColorFromDepth));
  const auto fit = fit_depth_to_color(frame);
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().what, HasSubstr("colour shows 5 markers, but where depth is missing only 0 show"));
}

TEST(Clicks, AreSavedAndLoaded) {
  const auto file =
      std::filesystem::temp_directory_path() / ("copresence_clicks_" + std::to_string(getpid()));
  ClickList list;
  list.click(10.5, 20);
  list.skip();
  list.click(1, 1);
  list.undo();
  list.click(30, 40.25);
  EXPECT_EQ(list.next(), 4);
  ASSERT_TRUE(save_clicks({{"left", list.markers()}}, file));
  const auto clicks = load_clicks(file);
  ASSERT_TRUE(clicks) << clicks.error().what;
  const auto& left = clicks->at("left");
  ASSERT_EQ(left.size(), 2u);
  EXPECT_EQ(left[0].name, "click1");  // Not "1", which may be a printed marker.
  EXPECT_EQ(left[1].name, "click3");
  EXPECT_EQ(left[1].middle, Eigen::Vector2d(30, 40.25));
  EXPECT_EQ(left[1].sigma_px, kClickSigma);

  std::ofstream(file) << "# fine\nleft 1 10 20\nleft 1 30 40\n";
  EXPECT_THAT(load_clicks(file).error().what, HasSubstr(":3: marker 1 of camera left is there twice"));
  std::ofstream(file) << "left 1 ten 20\n";
  EXPECT_THAT(load_clicks(file).error().what, HasSubstr(":1: a line must be"));
  std::filesystem::remove(file);
  EXPECT_EQ(load_clicks(file).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace copresence::calibrate
