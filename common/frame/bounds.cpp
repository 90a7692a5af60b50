#include "common/frame/bounds.h"

namespace copresence {

std::optional<Instant> instant_from_nanoseconds(std::uint64_t nanoseconds) {
  if (!is_within_bounds(nanoseconds)) return std::nullopt;
  const std::chrono::nanoseconds since_zero(static_cast<std::int64_t>(nanoseconds));
  return Instant(std::chrono::duration_cast<Duration>(since_zero));
}

Result<void> check_pose(const Rigid3& world_from_camera) {
  if (world_from_camera.is_rigid() &&
      world_from_camera.translation.cwiseAbs().maxCoeff() <= kFarthestCameraMetres) {
    return {};
  }
  return fail(ErrorCode::kInvalid, "a camera's pose must be a rotation and a translation of at most 10 km");
}

Result<void> check_noise(const DepthNoise& noise) {
  const bool plausible = noise.disparity_constant_m >= 50 && noise.disparity_constant_m <= 1e5 &&
                         noise.sigma_steps >= 0.01 && noise.sigma_steps <= 100;
  if (plausible) return {};
  return fail(
      ErrorCode::kInvalid,
      "a sensor's depth noise must have a disparity constant of 50 to 100000 m and a sigma of 0.01 to 100 "
      "steps");
}

}  // namespace copresence
