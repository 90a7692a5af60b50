#include "render_client/viewpoint/scripted_views.h"

#include <gtest/gtest.h>

namespace copresence::viewpoint {
namespace {

using Eigen::Vector3d;

PathView path_view(std::string_view text) {
  return {{}, EyePath::parse(text, "walk.txt").value(), Vector3d(0, -1, 0)};
}
Vector3d forward_at(PathView& path, std::uint64_t view) {
  return path.at(view, {}).world_from_eye.rotation.col(2);
}

TEST(PathView, StandsAndLooksWhereThePathSays) {
  auto path = path_view("0 0 0 0 0 0 1\n10 2 0 0 1 0 0\n");
  EXPECT_TRUE(path.at(5, {}).world_from_eye.translation.isApprox(Vector3d(1, 0, 0)));
  EXPECT_TRUE(forward_at(path, 0).isApprox(Vector3d(0, 0, 1)));
  EXPECT_TRUE(forward_at(path, 10).isApprox(Vector3d(-1, 0, 0)));
  EXPECT_TRUE(path.at(5, {}).world_from_eye.is_rigid(1e-12));
}

TEST(PathView, MayLookStraightDown) {
  auto path = path_view("0 0 -2 0 0 0 0\n");
  EXPECT_TRUE(forward_at(path, 0).isApprox(Vector3d(0, 1, 0)));
  EXPECT_TRUE(path.at(0, {}).world_from_eye.is_rigid(1e-12));
}

}  // namespace
}  // namespace copresence::viewpoint
