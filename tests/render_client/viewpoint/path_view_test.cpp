#include "render_client/viewpoint/path_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace copresence::viewpoint {
namespace {

using Eigen::Vector3d;

const Vector3d kUp{0, -1, 0};

Vector3d eye_at(PathView& path, std::uint64_t view) {
  return path.at(view, {}).world_from_eye.translation;
}
Vector3d forward_at(PathView& path, std::uint64_t view) {
  return path.at(view, {}).world_from_eye.rotation.col(2);
}

std::string refusal(std::string_view text) {
  const auto path = PathView::parse(text, "walk.txt", kUp);
  return path ? "accepted" : path.error().what;
}

TEST(PathView, MovesLinearlyBetweenItsLinesAndStandsStillOutside) {
  auto path = PathView::parse("10 0 0 0 0 0 2\n30 2 0 -1 2 0 3\n", "walk.txt", kUp).value();
  EXPECT_TRUE(eye_at(path, 0).isApprox(Vector3d(0, 0, 0)));
  EXPECT_TRUE(eye_at(path, 10).isApprox(Vector3d(0, 0, 0)));
  EXPECT_TRUE(eye_at(path, 15).isApprox(Vector3d(0.5, 0, -0.25)));
  EXPECT_TRUE(eye_at(path, 30).isApprox(Vector3d(2, 0, -1)));
  EXPECT_TRUE(eye_at(path, 1'000'000'000'000).isApprox(Vector3d(2, 0, -1)));
}

TEST(PathView, LooksAtThePointThatMovesWithIt) {
  auto path = PathView::parse("0 0 0 0 0 0 1\n10 0 0 0 1 0 0\n", "walk.txt", kUp).value();
  EXPECT_TRUE(forward_at(path, 0).isApprox(Vector3d(0, 0, 1)));
  EXPECT_TRUE(forward_at(path, 5).isApprox(Vector3d(1, 0, 1).normalized()));
  EXPECT_TRUE(forward_at(path, 10).isApprox(Vector3d(1, 0, 0)));
  EXPECT_TRUE(path.at(5, {}).world_from_eye.is_rigid(1e-12));
}

TEST(PathView, TakesCommentsEmptyLinesTabsAndWindowsEndings) {
  const auto path =
      PathView::parse("# a walk\r\n\r\n  0\t0 0 0  0 0 +1.5e0  # start\r\n\n5 1 0 0 0 0 1", "walk.txt", kUp);
  ASSERT_TRUE(path) << path.error().what;
}

TEST(PathView, NamesTheLineThatIsWrong) {
  EXPECT_THAT(refusal("0 0 0 0 0 0 1\n# fine\n1 2 3\n"),
              testing::StartsWith("walk.txt:3: 3 words where seven"));
  EXPECT_THAT(refusal("0 0 0 0 0 0 1 9"), testing::StartsWith("walk.txt:1: 8 words"));
  EXPECT_THAT(refusal("one 0 0 0 0 0 1"), testing::StartsWith("walk.txt:1: 'one' is no view index"));
  EXPECT_THAT(refusal("-1 0 0 0 0 0 1"), testing::HasSubstr("'-1' is no view index"));
  EXPECT_THAT(refusal("1.5 0 0 0 0 0 1"), testing::HasSubstr("'1.5' is no view index"));
  EXPECT_THAT(refusal("0 0 0 0 0 x 1"), testing::HasSubstr("'x' is no coordinate"));
  EXPECT_THAT(refusal("0 0 nan 0 0 0 1"), testing::HasSubstr("'nan' is no coordinate"));
  EXPECT_THAT(refusal("0 0 inf 0 0 0 1"), testing::HasSubstr("'inf' is no coordinate"));
  EXPECT_THAT(refusal("0 0 1e99 0 0 0 1"), testing::HasSubstr("'1e99' is no coordinate"));
  EXPECT_THAT(refusal("5 0 0 0 0 0 1\n5 0 0 0 0 0 2"),
              testing::StartsWith("walk.txt:2: view 5 comes after view 5"));
  EXPECT_THAT(refusal("0 1 1 1 1 1 1"), testing::HasSubstr("looks at the point where it stands"));
}

TEST(PathView, RefusesAFileThatSaysNothing) {
  EXPECT_THAT(refusal(""), testing::HasSubstr("no line says"));
  EXPECT_THAT(refusal("# only words\n\n"), testing::HasSubstr("no line says"));
}

TEST(PathView, SaysWhyAFileCannotBeRead) {
  const auto missing = PathView::load("/no/such/path.txt", kUp);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.error().what, "cannot read the path file /no/such/path.txt: No such file or directory");
  EXPECT_FALSE(PathView::load("/tmp", kUp));
}

TEST(PathView, LoadsAFile) {
  const std::string name = testing::TempDir() + "path_view_test.txt";
  std::ofstream(name) << "0 1 2 3 0 0 0\n";
  auto path = PathView::load(name, kUp);
  ASSERT_TRUE(path) << path.error().what;
  EXPECT_EQ(eye_at(*path, 3), Vector3d(1, 2, 3));
}

}  // namespace
}  // namespace copresence::viewpoint
