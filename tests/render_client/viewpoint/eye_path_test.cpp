#include "render_client/viewpoint/eye_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace copresence::viewpoint {
namespace {

using Eigen::Vector3d;

std::string refusal(std::string_view text) {
  const auto path = EyePath::parse(text, "walk.txt");
  return path ? "accepted" : path.error().what;
}

TEST(EyePath, MovesLinearlyBetweenItsLinesAndStandsStillOutside) {
  const auto path = EyePath::parse("10 0 0 0 0 0 2\n30 2 0 -1 2 0 3\n", "walk.txt").value();
  EXPECT_TRUE(path.at(0).eye.isApprox(Vector3d(0, 0, 0)));
  EXPECT_TRUE(path.at(10).eye.isApprox(Vector3d(0, 0, 0)));
  EXPECT_TRUE(path.at(15).eye.isApprox(Vector3d(0.5, 0, -0.25)));
  EXPECT_TRUE(path.at(15).look.isApprox(Vector3d(0.5, 0, 2.25)));
  EXPECT_TRUE(path.at(30).eye.isApprox(Vector3d(2, 0, -1)));
  EXPECT_TRUE(path.at(1'000'000'000'000).look.isApprox(Vector3d(2, 0, 3)));
}

// Accepts unusual forms that are valid.
TEST(EyePath, TakesCommentsBlankLinesTabsWindowsEndingsAndViewsFromAbove) {
  for (const char* text :
       {"0 0 0 0 0 0 1  # from the door\n", "0 0 0 0 0 0 1\n   \n5 1 0 0 0 0 1\n",
        "# a walk\r\n\r\n  0\t0 0 0  0 0 +1.5e0  # start\r\n\n5 1 0 0 0 0 1", "0 0 -2 0 0 0 0\n"}) {
    EXPECT_EQ(refusal(text), "accepted") << text;
  }
}

TEST(EyePath, NamesTheLineThatIsWrong) {
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

TEST(EyePath, RefusesAFileThatSaysNothing) {
  EXPECT_THAT(refusal(""), testing::HasSubstr("no line says"));
  EXPECT_THAT(refusal("# only words\n\n"), testing::HasSubstr("no line says"));
}

TEST(EyePath, QuotesNoMoreThanASentenceHolds) {
  std::string view, coordinate = "0 0 0 0 0 0 1";
  view.append(100'000, 'v').append(" 0 0 0 0 0 1");
  coordinate.append(100'000, '1');
  EXPECT_LT(refusal(view).size(), 200u);
  EXPECT_LT(refusal(coordinate).size(), 200u);
}

TEST(EyePath, SaysWhyAFileCannotBeRead) {
  const auto missing = EyePath::load("/no/such/path.txt");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().what, testing::HasSubstr("there is no file /no/such/path.txt"));
  EXPECT_FALSE(EyePath::load("/tmp"));
}

TEST(EyePath, LoadsAFile) {
  const std::string name = testing::TempDir() + "eye_path_test.txt";
  std::ofstream(name) << "0 1 2 3 0 0 0\n";
  const auto path = EyePath::load(name);
  ASSERT_TRUE(path) << path.error().what;
  EXPECT_EQ(path->at(3).eye, Vector3d(1, 2, 3));
}

}  // namespace
}  // namespace copresence::viewpoint
