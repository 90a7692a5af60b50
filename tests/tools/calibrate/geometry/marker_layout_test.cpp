#include "tools/calibrate/geometry/marker_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::calibrate {
namespace {

using testing::HasSubstr;

std::vector<NamedPoint> named(std::initializer_list<Eigen::Vector3d> places) {
  std::vector<NamedPoint> points;
  int number = 0;
  for (const Eigen::Vector3d& place : places) {
    std::string name(1, 'm');
    points.push_back({name += std::to_string(++number), place});
  }
  return points;
}

std::string problem(const std::vector<NamedPoint>& points, Solver solver = Solver::kRigid) {
  const auto checked = check_layout(points, solver, "left and right");
  return checked ? "" : checked.error().what;
}

TEST(Layout, TakesMarkersSpreadThroughTheRoom) {
  const auto points = named({{0, 0, 2}, {1, 0, 2.5}, {0, 0.8, 1.6}, {0.5, 0.3, 2.8}});
  EXPECT_EQ(problem(points), "");
  EXPECT_EQ(problem(points, Solver::kLinear), "");
}

TEST(Layout, AsksForFourMarkersInCommon) {
  EXPECT_THAT(problem({}), HasSubstr("left and right see no marker in common, but need 4"));
  EXPECT_THAT(problem(named({{0, 0, 2}})), HasSubstr("only 1 marker (m1)"));
  EXPECT_THAT(problem(named({{0, 0, 2}, {1, 0, 2}, {0, 1, 2}})), HasSubstr("only 3 markers (m1, m2 and m3)"));
}

TEST(Layout, SaysThatMarkersAreTooCloseTogether) {
  const std::string said = problem(named({{0, 0, 2}, {0.3, 0, 2}, {0, 0.3, 2}, {0.3, 0.3, 2.1}}));
  EXPECT_THAT(said, HasSubstr("all within 44 cm"));
  EXPECT_THAT(said, HasSubstr("until at least 60 cm"));
}

TEST(Layout, SaysWhichMarkerToMoveOffALine) {
  const std::string said = problem(named({{-1, 0, 2}, {-0.4, 0.02, 2}, {0.1, 0, 2.02}, {1, 0, 2}}));
  EXPECT_THAT(said, HasSubstr("(m1, m2, m3 and m4) lie almost on a line"));
  EXPECT_THAT(said, HasSubstr("move marker m3 at least 30 cm sideways"));
}

TEST(Layout, MindsAPlaneOnlyForTheLinearForm) {
  const auto wall = named({{-1, -0.5, 3}, {1, -0.5, 3.02}, {1, 0.8, 3}, {-1, 0.8, 3}, {0.1, 0.1, 3.01}});
  EXPECT_EQ(problem(wall), "");
  const std::string said = problem(wall, Solver::kLinear);
  EXPECT_THAT(said, HasSubstr("almost in one plane"));
  EXPECT_THAT(said, HasSubstr("move marker m5 at least 30 cm towards the cameras"));
}

}  // namespace
}  // namespace copresence::calibrate
