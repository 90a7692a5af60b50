#include "render_client/overlap_agreement.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

namespace copresence::client {
namespace {

constexpr int kSpacingPx = 12;
constexpr std::size_t kFewest = 50;

/// Returns the distance of a point of the other camera's frame from that camera's surface, along the
/// camera's axis. Returns nothing if the camera measures nothing there.
std::optional<double> distance_m(const CameraFrame& other, const Eigen::Vector3d& point) {
  if (!(point.z() > 0.05)) return std::nullopt;
  const CameraModel& model = other.setup->model;
  const Eigen::Vector2d pixel = project(model, point);
  if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < model.width - 0.5 &&
        pixel.y() < model.height - 0.5)) {
    return std::nullopt;
  }
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (other.frame.state(u, v) != DepthState::kMeasured) return std::nullopt;
  return std::abs(other.frame.depth(u, v) * metres_per_unit(other.setup->unit) - point.z());
}

}  // namespace

std::optional<double> median_disagreement_mm(const CameraFrame& camera,
                                             std::span<const CameraFrame* const> others) {
  std::vector<double> distances;
  const CameraModel& model = camera.setup->model;
  const double metres = metres_per_unit(camera.setup->unit);
  for (const CameraFrame* const other : others) {
    const Rigid3 other_from_camera = other->pose().inverse() * camera.pose();
    for (int y = kSpacingPx / 2; y < model.height; y += kSpacingPx) {
      for (int x = kSpacingPx / 2; x < model.width; x += kSpacingPx) {
        if (camera.frame.state(x, y) != DepthState::kMeasured) continue;
        const Eigen::Vector3d point =
            unproject(model, {double(x), double(y)}, camera.frame.depth(x, y) * metres);
        const auto distance = distance_m(*other, other_from_camera * point);
        if (distance && *distance < kSameSurfaceM) distances.push_back(*distance);
      }
    }
  }
  if (distances.size() < kFewest) return std::nullopt;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return 1000 * *middle;
}

}  // namespace copresence::client
