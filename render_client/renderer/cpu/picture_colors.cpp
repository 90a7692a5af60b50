#include "render_client/renderer/cpu/picture_colors.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "render_client/renderer/extension_rules.h"

namespace copresence::renderer {
namespace {

constexpr float kLeastRay = 0.2F;  // Of a ray's z in may_show().

Ints clamped(const Ints& value, int most) {
  return smaller(larger(value, Ints{}), all(most));
}

constexpr float kLeftOut = 1e9F;  // The inverse depth of a pixel that is left out: it hides everything.

// The inverse depths of a camera at eight positions.
class InverseSampler {
 public:
  explicit InverseSampler(const CameraPictures& pictures)
      : w_(pictures.inverse->w.data()),
        texels_(pictures.texture->data()),
        stride_(pictures.inverse->w.width()),
        texture_stride_(pictures.texture->width()),
        last_x_(pictures.inverse->width - 1),
        last_y_(pictures.inverse->height - 1) {}

  // Requires positions in the image or at most one pixel to the right of it or below.
  Floats at(const Ints& x, const Ints& y) const {
    const Ints index = y * stride_ + x, texel = y * texture_stride_ + x;
    Floats result{};
    for (int lane = 0; lane < kLanes; ++lane)
      result[lane] = texels_[texel[lane]] >> 24 == 0 ? kLeftOut : w_[index[lane]];
    return result;
  }
  Floats nearest(const Ints& x, const Ints& y) const { return at(clamped(x, last_x_), clamped(y, last_y_)); }

 private:
  const float* w_;
  const std::uint32_t* texels_;
  int stride_, texture_stride_, last_x_, last_y_;
};

// Moves positions away from pixels with an inverse depth above `nearest_visible`. The pixels beside
// them may have some of their colour. Returns the lanes in which not all pixels around are nearer.
Ints move_from_edges(const InverseSampler& inverse, const Floats& nearest_visible,
                     const Eigen::Vector2f& last, Floats& x, Floats& y) {
  const Ints column = truncated(x + 0.5F), row = truncated(y + 0.5F);
  const Ints is_left = inverse.nearest(column - kMixedColors, row) > nearest_visible;
  const Ints is_right = inverse.nearest(column + kMixedColors, row) > nearest_visible;
  const Ints is_above = inverse.nearest(column, row - kMixedColors) > nearest_visible;
  const Ints is_below = inverse.nearest(column, row + kMixedColors) > nearest_visible;
  // A true lane is -1.
  const auto moved = [](const Floats& from, const Ints& direction, float most) {
    return smaller(larger(from + as_floats(direction * kMixedColors), Floats{}), all(most));
  };
  x = moved(x, is_right - is_left, last.x());
  y = moved(y, is_below - is_above, last.y());
  return ~(is_left & is_right & is_above & is_below);
}

}  // namespace

Image<float> PictureColors::farthest_cells(const InverseDepth& inverse) {
  static_assert(kCell == 2 * kLanes, "a row of a cell is two vectors");
  Image<float> cells((inverse.width + kCell - 1) / kCell, (inverse.height + kCell - 1) / kCell);
  for (int cell_y = 0; cell_y < cells.height(); ++cell_y) {
    const int top = cell_y * kCell, bottom = std::min(top + kCell, inverse.height);
    for (int cell_x = 0; cell_x < cells.width(); ++cell_x) {
      // The last cell may end inside the padding, which repeats the last pixel, or before it.
      const int left = std::min(cell_x * kCell, inverse.w.width() - kCell);
      Floats least = load<Floats>(&inverse.w(left, top));
      for (int y = top; y < bottom; ++y) {
        const float* const row = &inverse.w(left, y);
        least = smaller(least, smaller(load<Floats>(row), load<Floats>(row + kLanes)));
      }
      float& cell = cells(cell_x, cell_y) = least[0];
      for (int lane = 1; lane < kLanes; ++lane) cell = std::min(cell, least[lane]);
    }
  }
  return cells;
}

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
         .farthest = farthest_cells(*pictures[i].inverse),
         .opacity = camera.opacity});
  }
}

Eigen::Vector2f PictureColors::Camera::pixel(const Eigen::Vector3f& ray) const {
  if (is_distorted) return project(model, ray.cast<double>()).cast<float>();
  return (ray.head<2>() * (1 / ray.z())).cwiseProduct(focal) + center;
}

bool PictureColors::Camera::has_farther(const Eigen::Vector2f& at, float radius,
                                        float nearest_visible) const {
  if (at.x() < -radius || at.y() < -radius || at.x() > last.x() + radius || at.y() > last.y() + radius)
    return false;
  const auto cell = [](float position, int count) {
    return std::clamp(static_cast<int>(position) / kCell, 0, count - 1);
  };
  const int left = cell(at.x() - radius, farthest.width()), right = cell(at.x() + radius, farthest.width());
  const int top = cell(at.y() - radius, farthest.height()), bottom = cell(at.y() + radius, farthest.height());
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      if (farthest(x, y) <= nearest_visible) return true;
    }
  }
  return false;
}

bool PictureColors::may_show(int left, int top, int size, float w) const {
  constexpr float kMostChangeInBlock = kMostSlope / 2;  // Of w, from the middle to the border.
  const float half = 0.5F * static_cast<float>(size - 1);
  const Eigen::Vector3f center(static_cast<float>(left) + half, static_cast<float>(top) + half, 1);
  for (const Camera& camera : cameras_) {
    const Eigen::Vector3f ray = camera.rays * center + w * camera.origin;
    // Close to the camera's plane, and with distortion, a square has no simple outline.
    if (camera.is_distorted || std::abs(ray.z()) < kLeastRay) return true;
    if (ray.z() < 0) continue;
    const float shift = kMostChangeInBlock * camera.origin.norm() * camera.focal.maxCoeff();
    const float diagonal = 0.71F * static_cast<float>(size) * camera.pixels_per_pixel;
    const float radius = (shift + diagonal) / ray.z() + static_cast<float>(kMixedColors + 2);
    const float nearest_visible = (w + kMostChangeInBlock) / (0.9F * ray.z()) + kOwnSurface;
    if (camera.has_farther(camera.pixel(ray), radius, nearest_visible)) return true;
  }
  return false;
}

PictureColors::Colors PictureColors::find(int x, int y, const Floats& w, const Ints& wanted) const {
  const Floats column = ramp() + static_cast<float>(x);
  const auto row = static_cast<float>(y);
  Colors colors{};
  Ints open = wanted;
  for (const Camera& camera : cameras_) {
    const auto coordinate = [&](int i) {
      return camera.rays(i, 0) * column + (camera.rays(i, 1) * row + camera.rays(i, 2)) +
             w * camera.origin[i];
    };
    const Floats ray_x = coordinate(0), ray_y = coordinate(1), ray_z = coordinate(2);
    Ints sees = open & (ray_z > 0);
    if (bits(sees) == 0) continue;
    const Floats per_z = 1 / (sees ? ray_z : all(1.0F));
    Floats u = ray_x * per_z * camera.focal.x() + camera.center.x();
    Floats v = ray_y * per_z * camera.focal.y() + camera.center.y();
    if (camera.is_distorted) {
      for (unsigned lanes = bits(sees); lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        const Eigen::Vector2f pixel = camera.pixel({ray_x[lane], ray_y[lane], ray_z[lane]});
        u[lane] = pixel.x();
        v[lane] = pixel.y();
      }
    }
    sees &= (u >= 0) & (v >= 0) & (u <= camera.last.x()) & (v <= camera.last.y());
    if (bits(sees) == 0) continue;
    u = sees ? u : Floats{};
    v = sees ? v : Floats{};
    const InverseSampler inverse(camera.pictures);
    const Floats nearest_visible = w * per_z + kOwnSurface;
    sees &= move_from_edges(inverse, nearest_visible, camera.last, u, v);
    if (bits(sees) == 0) continue;
    const Ints left = truncated(u), top = truncated(v);
    const Floats right_share = u - as_floats(left), lower_share = v - as_floats(top);
    const CameraTexture& texture = *camera.pictures.texture;
    Floats r{}, g{}, b{}, shares{};
    for (int i = 0; i < 4; ++i) {
      const Ints at_x = left + (i & 1), at_y = top + (i >> 1);
      const Floats corner =
          ((i & 1) != 0 ? right_share : 1 - right_share) * ((i >> 1) != 0 ? lower_share : 1 - lower_share);
      const Floats share = inverse.at(at_x, at_y) <= nearest_visible ? corner : Floats{};
      const Ints texels = gather(texture.data(), at_y * texture.width() + at_x);
      r += share * as_floats(texels & 0xFF);
      g += share * as_floats(texels >> 8 & 0xFF);
      b += share * as_floats(texels >> 16 & 0xFF);
      shares += share;
    }
    sees &= shares >= kLeastVisibleShare;
    const Floats scale = camera.opacity / larger(shares, all(kLeastVisibleShare));
    colors.r = sees ? r * scale : colors.r;
    colors.g = sees ? g * scale : colors.g;
    colors.b = sees ? b * scale : colors.b;
    colors.found |= sees;
    open &= ~sees;
    if (bits(open) == 0) break;
  }
  return colors;
}

}  // namespace copresence::renderer
