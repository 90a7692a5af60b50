#include "render_client/overlap_agreement.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>

namespace copresence::client {
namespace {

/// A camera at (x_m, 0, 0) that looks along the world's z axis at a wall. Depth is in millimetres.
CameraFrame camera_before_wall(double x_m, std::uint16_t wall_mm, DepthState state = DepthState::kMeasured) {
  auto setup = std::make_shared<CameraSetup>();
  setup->model = nominal_kinect(320, 240);
  setup->has_pose = true;
  setup->fixed_pose = Rigid3{};
  setup->fixed_pose->translation.x() = x_m;
  CameraFrame camera{};
  camera.frame.depth = DepthImage(320, 240, wall_mm);
  camera.frame.state = StateImage(320, 240, state);
  camera.setup = std::move(setup);
  return camera;
}

std::optional<double> disagreement(const CameraFrame& camera, const CameraFrame& other) {
  const std::array others{&other};
  return median_disagreement_mm(camera, others);
}

TEST(OverlapAgreement, IsTheDistanceBetweenTheSurfaces) {
  const CameraFrame left = camera_before_wall(0, 2000);
  EXPECT_NEAR(*disagreement(left, camera_before_wall(0.5, 2007)), 7, 1e-6);
  EXPECT_NEAR(*disagreement(left, camera_before_wall(0.5, 1988)), 12, 1e-6);
}

TEST(OverlapAgreement, IsTheMedianOverAllOtherCameras) {
  const CameraFrame left = camera_before_wall(0, 2000), middle = camera_before_wall(0.1, 2003),
                    right = camera_before_wall(1.2, 2050);
  const std::array<const CameraFrame*, 2> others{&middle, &right};
  EXPECT_NEAR(*median_disagreement_mm(left, others), 3, 1e-6) << "the middle camera overlaps more";
}

TEST(OverlapAgreement, IgnoresOtherSurfacesAndFilledDepth) {
  const CameraFrame left = camera_before_wall(0, 2000);
  EXPECT_FALSE(disagreement(left, camera_before_wall(0.5, 2101)));
  EXPECT_FALSE(disagreement(left, camera_before_wall(0.5, 2005, DepthState::kFilled)));
  EXPECT_FALSE(disagreement(camera_before_wall(0, 2000, DepthState::kFilled), left));
}

TEST(OverlapAgreement, IsUnknownWithoutOverlap) {
  const CameraFrame left = camera_before_wall(0, 2000);
  EXPECT_FALSE(disagreement(left, camera_before_wall(5, 2000)));
  EXPECT_FALSE(median_disagreement_mm(left, {}));
}

}  // namespace
}  // namespace copresence::client
