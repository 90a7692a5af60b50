#include "capture_server/registration/registration.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace copresence::registration {
namespace {

constexpr float kNowhere = -1e6f;    // A coordinate outside every picture.
constexpr float kNearestM = 0.05f;   // In metres. Points closer to the colour camera count as behind it.
constexpr float kUnknownDepthM = 2;  // Assumed depth in metres of rows above the first row with depth.
constexpr float kFarAway = std::numeric_limits<float>::max();

/// A surface behind this depth is hidden by the nearest surface, at depth z. The limit is six
/// disparity steps plus the change of a slanted surface from one pixel to the next.
float hidden_beyond(float z, const DepthNoise& noise) {
  return z + 0.02f + 6 * static_cast<float>(noise.step_m(z));
}

/// Rounds a non-negative value. std::lround() would be a function call for every pixel.
int rounded(float value) {
  return static_cast<int>(value + 0.5f);  // NOLINT(bugprone-incorrect-roundings)
}

/// The bilinearly interpolated colour at (u, v). Requires 0 <= u <= width - 1, and v likewise.
Rgb8 sample(const ColorImage& color, float u, float v) {
  const int x = std::min(static_cast<int>(u), color.width() - 2),
            y = std::min(static_cast<int>(v), color.height() - 2);
  const int right = rounded((u - float(x)) * 256), down = rounded((v - float(y)) * 256);
  const Rgb8* top = &color(x, y);
  const Rgb8* bottom = &color(x, y + 1);
  const auto blend = [&](int a, int b, int c, int d) {
    return static_cast<std::uint8_t>(
        ((a * (256 - right) + b * right) * (256 - down) + (c * (256 - right) + d * right) * down + 32768) >>
        16);
  };
  return {blend(top[0].r, top[1].r, bottom[0].r, bottom[1].r),
          blend(top[0].g, top[1].g, bottom[0].g, bottom[1].g),
          blend(top[0].b, top[1].b, bottom[0].b, bottom[1].b)};
}

/// Fills `depths` with the depth of one row in metres. A hole gets the larger of the measured
/// depths next to it. If the row has no depth at all, `depths` keeps the values of the row above.
void assume_depths(std::span<const std::uint16_t> measured, float metres_per_unit, std::span<float> depths) {
  const int width = static_cast<int>(measured.size());
  int last = -1;
  for (int x = 0; x <= width; ++x) {
    if (x < width && measured[x] == 0) continue;
    const float here = x < width ? measured[x] * metres_per_unit : 0;
    const float before = last >= 0 ? depths[last] : 0;
    if (std::max(here, before) > 0)
      std::fill(depths.begin() + last + 1, depths.begin() + x, std::max(here, before));
    if (x < width) depths[x] = here;
    last = x;
  }
}

}  // namespace

Result<Registration> Registration::open(const SensorCameras& cameras) {
  if (auto valid = check(cameras.depth); !valid) return fail(valid.error());
  Registration registration;
  registration.depth_ = cameras.depth;
  registration.metres_per_unit_ = static_cast<float>(metres_per_unit(cameras.unit));
  registration.noise_ = cameras.noise;
  if (!cameras.color) return registration;

  if (auto valid = check(*cameras.color); !valid) return fail(valid.error());
  if (!cameras.registered && !cameras.color_from_depth.is_rigid()) {
    return fail(ErrorCode::kInvalid, "color_from_depth is not a rotation and a translation");
  }
  registration.has_color_ = true;
  registration.color_ = *cameras.color;
  const CameraModel &depth = registration.depth_, &color = registration.color_;
  const Rigid3 color_from_depth = cameras.registered ? Rigid3{} : cameras.color_from_depth;
  const bool same_size = depth.width == color.width && depth.height == color.height;
  if (same_size && (cameras.registered || (depth == color && color_from_depth == Rigid3{})))
    return registration;

  registration.mapping_ = color_from_depth.translation.isZero() ? Mapping::kFixed : Mapping::kDepth;
  registration.translation_ = color_from_depth.translation.cast<float>();
  const double scale = color.fx * depth.width / (color.width * depth.fx);
  registration.footprint_ = std::clamp(static_cast<int>(std::ceil(scale - 0.05)) + 1, 2, 4);
  const std::size_t pixels = static_cast<std::size_t>(depth.width) * depth.height;
  for (auto* plane : {&registration.ray_x_, &registration.ray_y_, &registration.ray_z_, &registration.u_,
                      &registration.v_, &registration.z_}) {
    plane->resize(pixels);
  }
  registration.nearest_z_.resize(pixels, kFarAway);
  const std::vector<Eigen::Vector2f> depth_rays = rays(depth);
  const Eigen::Matrix3f rotation = color_from_depth.rotation.cast<float>();
  for (std::size_t i = 0; i < pixels; ++i) {
    const Eigen::Vector3f ray = rotation * depth_rays[i].homogeneous();
    registration.ray_x_[i] = ray.x();
    registration.ray_y_[i] = ray.y();
    registration.ray_z_[i] = ray.z();
  }
  if (registration.mapping_ == Mapping::kFixed) {
    registration.row_z_.assign(depth.width, 1.0f);
    for (int y = 0; y < depth.height; ++y) registration.map_row({}, y);
  }
  return registration;
}

RgbdFrame Registration::apply(RgbdFrame frame) {
  assert(frame.depth.width() == depth_.width && frame.depth.height() == depth_.height);
  assert(same_shape(frame.depth, frame.state));
  if (!frame.color) return frame;
  if (!has_color_ || frame.color->width() != color_.width || frame.color->height() != color_.height) {
    frame.color.reset();
    return frame;
  }
  if (mapping_ == Mapping::kNone) return frame;
  if (mapping_ == Mapping::kDepth) {
    row_z_.assign(depth_.width, kUnknownDepthM);
    std::fill(nearest_z_.begin(), nearest_z_.end(), kFarAway);
    for (int y = 0; y < depth_.height; ++y) {
      map_row(frame, y);
      splat_row(frame, y);
    }
  }
  ColorImage color(depth_.width, depth_.height);
  for (int y = 0; y < depth_.height; ++y) color_row(*frame.color, y, color.row(y));
  frame.color = std::move(color);
  return frame;
}

/// Computes where the pixels of row y appear in the colour camera: u_, v_ and z_.
void Registration::map_row(const RgbdFrame& frame, int y) {
  if (mapping_ == Mapping::kDepth) assume_depths(frame.depth.row(y), metres_per_unit_, row_z_);
  const std::size_t first = static_cast<std::size_t>(y) * depth_.width;
  const float *X = &ray_x_[first], *Y = &ray_y_[first], *Z = &ray_z_[first];
  const float fx = float(color_.fx), fy = float(color_.fy), cx = float(color_.cx), cy = float(color_.cy);
  const float tx = translation_.x(), ty = translation_.y(), tz = translation_.z();
  const bool distorted = color_.is_distorted();
  std::array<float, 8> k{};
  std::transform(color_.distortion.begin(), color_.distortion.end(), k.begin(),
                 [](double c) { return float(c); });
  for (int i = 0; i < depth_.width; ++i) {
    const float z = row_z_[i] * Z[i] + tz;
    const bool in_front = z > kNearestM;
    const float inverse = 1 / (in_front ? z : 1);
    float x = (row_z_[i] * X[i] + tx) * inverse, y_over_z = (row_z_[i] * Y[i] + ty) * inverse;
    if (distorted) {
      const float r2 = x * x + y_over_z * y_over_z;
      const float radial =
          (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
      const float dx = x * radial + 2 * k[2] * x * y_over_z + k[3] * (r2 + 2 * x * x);
      y_over_z = y_over_z * radial + k[2] * (r2 + 2 * y_over_z * y_over_z) + 2 * k[3] * x * y_over_z;
      x = dx;
    }
    u_[first + i] = in_front ? fx * x + cx : kNowhere;
    v_[first + i] = in_front ? fy * y_over_z + cy : kNowhere;
    z_[first + i] = z;
  }
}

/// Updates the nearest depths of the colour camera with the measured pixels of row y.
void Registration::splat_row(const RgbdFrame& frame, int y) {
  const std::size_t first = static_cast<std::size_t>(y) * depth_.width;
  const float grid_x = float(depth_.width) / float(color_.width),
              grid_y = float(depth_.height) / float(color_.height);
  const std::span<const std::uint16_t> measured = frame.depth.row(y);
  for (int i = 0; i < depth_.width; ++i) {
    if (measured[i] == 0) continue;
    const float left = u_[first + i] * grid_x - 0.5f * float(footprint_ - 2);
    const float top = v_[first + i] * grid_y - 0.5f * float(footprint_ - 2);
    if (!(left >= 0 && left < float(depth_.width - footprint_) && top >= 0 &&
          top < float(depth_.height - footprint_))) {
      continue;
    }
    float* cell = &nearest_z_[static_cast<std::size_t>(top) * depth_.width + static_cast<std::size_t>(left)];
    const float z = z_[first + i];
    for (int dy = 0; dy < footprint_; ++dy, cell += depth_.width) {
      for (int dx = 0; dx < footprint_; ++dx) cell[dx] = std::min(cell[dx], z);
    }
  }
}

bool Registration::is_visible(std::size_t at) const {
  const float u = u_[at], v = v_[at];
  if (!(u >= 0 && u <= float(color_.width - 1) && v >= 0 && v <= float(color_.height - 1))) return false;
  if (mapping_ == Mapping::kFixed) return true;
  const int x = rounded(u * float(depth_.width) / float(color_.width));
  const int y = rounded(v * float(depth_.height) / float(color_.height));
  const std::size_t cell = static_cast<std::size_t>(std::min(y, depth_.height - 1)) * depth_.width +
                           static_cast<std::size_t>(std::min(x, depth_.width - 1));
  return z_[at] <= hidden_beyond(nearest_z_[cell], noise_);
}

void Registration::color_row(const ColorImage& from, int y, std::span<Rgb8> to) {
  const std::size_t first = static_cast<std::size_t>(y) * depth_.width;
  int last = -1;  // The last visible pixel.
  for (int x = 0; x <= depth_.width; ++x) {
    const bool at_end = x == depth_.width;
    if (!at_end) {
      if (!is_visible(first + x)) continue;
      to[x] = sample(from, u_[first + x], v_[first + x]);
    }
    for (int hidden = last + 1; hidden < x; ++hidden) {
      const float z = z_[first + hidden];
      const bool left =
          last >= 0 && (at_end || std::abs(z_[first + last] - z) <= std::abs(z_[first + x] - z));
      if (left || !at_end) to[hidden] = to[left ? last : x];
    }
    last = x;
  }
}

}  // namespace copresence::registration
