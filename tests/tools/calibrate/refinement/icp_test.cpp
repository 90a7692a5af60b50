#include "tools/calibrate/refinement/icp.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tests/tools/calibrate/refinement/scenes.h"

namespace copresence::calibrate {
namespace {

constexpr IcpLevel kLevel{0.05, 1, 1};

// A picture of one block, so that all of its errors are dependent.
Surface seen_small(const Rigid3& pose) {
  const CameraModel camera{kBlock_px, kBlock_px, 44, 44, 23.5, 23.5, {}};
  return make_surface(test::depth_of(test::furnished_room(), camera, pose), camera);
}

TEST(Scatter, OfPicturesOfOneBlockIsTheGradientSquared) {
  const Rigid3 left = test::look_from({-0.6, -1.5, -0.8}, {0, -0.6, 1}),
               right = test::look_from({0.6, -1.5, -0.8}, {0, -0.6, 1});
  const std::vector<Surface> surfaces{seen_small(left), seen_small(right)};
  const std::vector<Rigid3> poses{left, test::disturbed(right, {0.01, 0, 0.005}, {0, 1, 0}, 0.2)};
  const NormalEquations equations =
      normal_equations({surfaces, {1}, {{0, 1}}}, poses, kLevel, Extra::kScatter);
  ASSERT_GT(equations.matches, 100);
  const Eigen::MatrixXd squared = equations.gradient * equations.gradient.transpose();
  EXPECT_LT((equations.scatter - squared).norm(), 1e-6 * squared.norm());
}

TEST(Scatter, JoinsWhatHangsOnOneCameraInAllItsPairs) {
  const Rigid3 left = test::look_from({-0.6, -1.5, -0.8}, {0, -0.6, 1}),
               middle = test::look_from({0, -1.6, -0.9}, {0, -0.6, 1}),
               right = test::look_from({0.6, -1.5, -0.8}, {0, -0.6, 1});
  const std::vector<Surface> surfaces{seen_small(middle), seen_small(left), seen_small(right)};
  const std::vector<Rigid3> poses{middle, test::disturbed(left, {0.01, 0, 0.005}, {0, 1, 0}, 0.2),
                                  test::disturbed(right, {0.01, 0, -0.005}, {1, 0, 0}, 0.2)};
  const NormalEquations equations =
      normal_equations({surfaces, {1, 2}, {{0, 1}, {0, 2}}}, poses, kLevel, Extra::kScatter);
  // An error of the first camera moves both others in the same way.
  const Eigen::MatrixXd squared = equations.gradient * equations.gradient.transpose();
  EXPECT_GT((squared.topRightCorner<6, 6>().norm()), 0.1 * squared.norm());
  EXPECT_LT((equations.scatter - squared).norm(), 1e-6 * squared.norm());
}

TEST(Scatter, OfManyBlocksKnowsMoreThanOfOne) {
  const Rigid3 left = test::look_from({-0.6, -1.5, -0.8}, {0, -0.6, 1}),
               right = test::look_from({0.6, -1.5, -0.8}, {0, -0.6, 1});
  const CameraModel camera = test::small_camera();
  std::vector<Surface> surfaces;
  for (const auto& [pose, seed] : {std::pair(left, 1u), std::pair(right, 2u)}) {
    surfaces.push_back(make_surface(test::depth_of(test::furnished_room(), camera, pose, seed), camera));
  }
  const NormalEquations equations =
      normal_equations({surfaces, {1}, {{0, 1}}}, std::vector{left, right}, kLevel, Extra::kScatter);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(equations.scatter);
  EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-9 * solver.eigenvalues().maxCoeff());
  EXPECT_GT(solver.eigenvalues()[3], 0) << "as many blocks as it takes to tell six numbers";
  EXPECT_EQ(normal_equations({surfaces, {1}, {{0, 1}}}, std::vector{left, right}, kLevel).scatter.size(), 0);
}

}  // namespace
}  // namespace copresence::calibrate
