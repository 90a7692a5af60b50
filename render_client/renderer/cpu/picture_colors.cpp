#include "render_client/renderer/cpu/picture_colors.h"

#include <algorithm>
#include <cassert>
#include <cstdint>

#include "render_client/renderer/extension_rules.h"

namespace copresence::renderer {
namespace {

// The pixel of the camera that shows the direction of `ray`. Requires ray.z() > 0.
Eigen::Vector2f pixel_of(const CameraModel& model, const Eigen::Vector3f& ray) {
  if (model.is_distorted()) return project(model, ray.cast<double>()).cast<float>();
  const float scale = 1 / ray.z();
  return {ray.x() * scale * static_cast<float>(model.fx) + static_cast<float>(model.cx),
          ray.y() * scale * static_cast<float>(model.fy) + static_cast<float>(model.cy)};
}

// Moves a position away from pixels that are nearer than 1 / nearest_visible. The pixels beside them
// may carry some of their colour.
Eigen::Vector2f away_from_edges(const InverseDepth& inverse, float nearest_visible,
                                const Eigen::Vector2f& at) {
  const int x = static_cast<int>(at.x() + 0.5F), y = static_cast<int>(at.y() + 0.5F);
  const auto is_hidden = [&](int u, int v) {
    return inverse.w(std::clamp(u, 0, inverse.width - 1), std::clamp(v, 0, inverse.height - 1)) >
           nearest_visible;
  };
  const int right = is_hidden(x - kMixedColors, y) - is_hidden(x + kMixedColors, y);
  const int down = is_hidden(x, y - kMixedColors) - is_hidden(x, y + kMixedColors);
  return {std::clamp(at.x() + static_cast<float>(kMixedColors * right), 0.0F,
                     static_cast<float>(inverse.width - 1)),
          std::clamp(at.y() + static_cast<float>(kMixedColors * down), 0.0F,
                     static_cast<float>(inverse.height - 1))};
}

}  // namespace

void PictureColors::begin(const ViewPose& eye, std::span<const CameraView> cameras,
                          std::span<const CameraPictures> pictures) {
  assert(cameras.size() == pictures.size());
  cameras_.clear();
  const CameraModel& view = eye.intrinsics;
  Eigen::Matrix3d ray_from_pixel;
  ray_from_pixel << 1 / view.fx, 0, -view.cx / view.fx, 0, 1 / view.fy, -view.cy / view.fy, 0, 0, 1;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraView& camera = cameras[i];
    if (!(camera.opacity > 0) || camera.is_remembered || !camera.frame->color) continue;
    const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
    cameras_.push_back({pictures[i], camera.model, (camera_from_eye.rotation * ray_from_pixel).cast<float>(),
                        camera_from_eye.translation.cast<float>(), camera.opacity});
  }
}

std::optional<PictureColors::Color> PictureColors::find(int x, int y, float w) const {
  const Eigen::Vector3f pixel(static_cast<float>(x), static_cast<float>(y), 1);
  for (const Camera& camera : cameras_) {
    const Eigen::Vector3f ray = camera.rays * pixel + w * camera.origin;
    if (!(ray.z() > 0)) continue;
    Eigen::Vector2f at = pixel_of(camera.model, ray);
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() <= static_cast<float>(camera.model.width - 1) &&
          at.y() <= static_cast<float>(camera.model.height - 1))) {
      continue;
    }
    const float nearest_visible = w / ray.z() + kOwnSurface;
    at = away_from_edges(*camera.pictures.inverse, nearest_visible, at);
    const int left = static_cast<int>(at.x()), top = static_cast<int>(at.y());
    const float right_share = at.x() - static_cast<float>(left),
                lower_share = at.y() - static_cast<float>(top);
    Color sum{0, 0, 0};
    float shares = 0;
    for (int i = 0; i < 4; ++i) {
      const int u = left + (i & 1), v = top + (i >> 1);
      if (camera.pictures.inverse->w(u, v) > nearest_visible) continue;
      const float share =
          ((i & 1) != 0 ? right_share : 1 - right_share) * ((i >> 1) != 0 ? lower_share : 1 - lower_share);
      const std::uint32_t texel = (*camera.pictures.texture)(u, v);
      sum.r += share * static_cast<float>(texel & 0xFF);
      sum.g += share * static_cast<float>(texel >> 8 & 0xFF);
      sum.b += share * static_cast<float>(texel >> 16 & 0xFF);
      shares += share;
    }
    if (shares < kLeastVisibleShare) continue;
    const float scale = camera.opacity / shares;
    return Color{sum.r * scale, sum.g * scale, sum.b * scale};
  }
  return std::nullopt;
}

}  // namespace copresence::renderer
