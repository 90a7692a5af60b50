#include "render_client/renderer/cpu/picture_colors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "render_client/renderer/extension_rules.h"

namespace copresence::renderer {
namespace {

constexpr float kLeastRay = 0.2F;  // Of a ray's z in may_show().

bool is_hidden(const InverseDepth& inverse, float nearest_visible, int x, int y) {
  return inverse.w(std::clamp(x, 0, inverse.width - 1), std::clamp(y, 0, inverse.height - 1)) >
         nearest_visible;
}

// Moves a position away from pixels with an inverse depth above `nearest_visible`. The pixels
// beside them may have some of their colour. Returns nothing if all pixels around are nearer.
std::optional<Eigen::Vector2f> away_from_edges(const InverseDepth& inverse, float nearest_visible,
                                               const Eigen::Vector2f& at) {
  const int x = static_cast<int>(at.x() + 0.5F), y = static_cast<int>(at.y() + 0.5F);
  const bool is_left = is_hidden(inverse, nearest_visible, x - kMixedColors, y);
  const bool is_right = is_hidden(inverse, nearest_visible, x + kMixedColors, y);
  const bool is_above = is_hidden(inverse, nearest_visible, x, y - kMixedColors);
  const bool is_below = is_hidden(inverse, nearest_visible, x, y + kMixedColors);
  if (is_left && is_right && is_above && is_below) return std::nullopt;
  const auto moved = [](float from, int direction, int size) {
    return std::clamp(from + static_cast<float>(kMixedColors * direction), 0.0F,
                      static_cast<float>(size - 1));
  };
  return Eigen::Vector2f(moved(at.x(), is_left - is_right, inverse.width),
                         moved(at.y(), is_above - is_below, inverse.height));
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
    const CameraModel& model = camera.model;
    cameras_.push_back(
        {.pictures = pictures[i],
         .model = model,
         .is_distorted = model.is_distorted(),
         .focal = Eigen::Vector2d(model.fx, model.fy).cast<float>(),
         .center = Eigen::Vector2d(model.cx, model.cy).cast<float>(),
         .last = Eigen::Vector2i(model.width - 1, model.height - 1).cast<float>(),
         .rays = (camera_from_eye.rotation * ray_from_pixel).cast<float>(),
         .origin = camera_from_eye.translation.cast<float>(),
         .pixels_per_pixel = static_cast<float>(std::max(model.fx / view.fx, model.fy / view.fy)),
         .opacity = camera.opacity});
  }
}

Eigen::Vector2f PictureColors::Camera::pixel(const Eigen::Vector3f& ray) const {
  if (is_distorted) return project(model, ray.cast<double>()).cast<float>();
  return (ray.head<2>() * (1 / ray.z())).cwiseProduct(focal) + center;
}

bool PictureColors::may_show(int left, int top, int size, float w) const {
  const float half = 0.5F * static_cast<float>(size - 1);
  const Eigen::Vector3f center(static_cast<float>(left) + half, static_cast<float>(top) + half, 1);
  for (const Camera& camera : cameras_) {
    const Eigen::Vector3f ray = camera.rays * center + w * camera.origin;
    // Close to the camera's plane, and with distortion, a square has no simple outline.
    if (camera.is_distorted || std::abs(ray.z()) < kLeastRay) return true;
    if (ray.z() < 0) continue;
    const Eigen::Vector2f pixel = camera.pixel(ray);
    const float margin = 2 * static_cast<float>(size) * (1 + camera.pixels_per_pixel / ray.z());
    if (pixel.x() >= -margin && pixel.y() >= -margin && pixel.x() <= camera.last.x() + margin &&
        pixel.y() <= camera.last.y() + margin) {
      return true;
    }
  }
  return false;
}

std::optional<PictureColors::Color> PictureColors::find(int x, int y, float w) const {
  const Eigen::Vector3f pixel(static_cast<float>(x), static_cast<float>(y), 1);
  for (const Camera& camera : cameras_) {
    const Eigen::Vector3f ray = camera.rays * pixel + w * camera.origin;
    if (!(ray.z() > 0)) continue;
    const Eigen::Vector2f pixel_in_camera = camera.pixel(ray);
    if (!(pixel_in_camera.x() >= 0 && pixel_in_camera.y() >= 0 && pixel_in_camera.x() <= camera.last.x() &&
          pixel_in_camera.y() <= camera.last.y())) {
      continue;
    }
    const float nearest_visible = w / ray.z() + kOwnSurface;
    const auto at = away_from_edges(*camera.pictures.inverse, nearest_visible, pixel_in_camera);
    if (!at) continue;
    const int left = static_cast<int>(at->x()), top = static_cast<int>(at->y());
    const float right_share = at->x() - static_cast<float>(left);
    const float lower_share = at->y() - static_cast<float>(top);
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
