#pragma once

// Frames of surfaces with known points, and eyes that look at them.

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

inline CameraModel kinect_model() {
  return {640, 480, 585, 585, 320, 240, {}};
}

/// Depth in metres along the ray (x, y, 1). Nothing if there is no surface.
using Surface = std::function<std::optional<double>(double x, double y)>;
/// Colour of the pixel (u, v).
using Paint = std::function<Rgb8(int u, int v)>;

/// The plane n.P = d.
inline Surface plane(const Eigen::Vector3d& n, double d) {
  return [n, d](double x, double y) -> std::optional<double> {
    const double along = n.dot(Eigen::Vector3d(x, y, 1));
    return along * d > 0 ? std::optional(d / along) : std::nullopt;
  };
}
inline Surface wall(double z_m) {
  return plane({0, 0, 1}, z_m);
}

inline Surface sphere(const Eigen::Vector3d& center, double radius) {
  return [center, radius](double x, double y) -> std::optional<double> {
    const Eigen::Vector3d ray(x, y, 1);
    const double a = ray.squaredNorm(), b = ray.dot(center), c = center.squaredNorm() - radius * radius;
    const double root = b * b - a * c;
    return root > 0 ? std::optional((b - std::sqrt(root)) / a) : std::nullopt;
  };
}

/// The nearest of several surfaces.
inline Surface together(std::vector<Surface> surfaces) {
  return [surfaces](double x, double y) {
    std::optional<double> nearest;
    for (const Surface& surface : surfaces) {
      const auto z = surface(x, y);
      if (z && (!nearest || *z < *nearest)) nearest = z;
    }
    return nearest;
  };
}

inline Paint plain(Rgb8 color) {
  return [color](int, int) { return color; };
}
/// Brightness that rises smoothly over the image, so that every pixel differs from its neighbours.
inline Rgb8 gradient(int u, int v) {
  return {std::uint8_t(30 + u * 200 / 640), std::uint8_t(30 + v * 200 / 480), 128};
}

/// The frame that a camera takes of a surface, accurate to 0.1 mm.
inline RgbdFrame frame_of(const CameraModel& camera, const Surface& surface,
                          const std::optional<Paint>& paint) {
  RgbdFrame frame;
  frame.depth = DepthImage(camera.width, camera.height);
  frame.state = StateImage(camera.width, camera.height, DepthState::kHole);
  if (paint) frame.color = ColorImage(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = unproject(camera, {double(u), double(v)}, 1);
      const auto z = surface(ray.x(), ray.y());
      if (z && *z > 0.3 && *z < 6.5) {
        frame.depth(u, v) = std::uint16_t(std::lround(*z * 1e4));
        frame.state(u, v) = DepthState::kMeasured;
      }
      if (paint) (*frame.color)(u, v) = (*paint)(u, v);
    }
  }
  return frame;
}

/// The same as a Kinect measures it: noise of half a step, rounded to whole steps. `holes` is the
/// fraction without depth, in round patches.
inline void measure_like_a_kinect(RgbdFrame& frame, double holes, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1.0 / 3);
  for (auto& value : frame.depth.pixels()) {
    if (value == 0) continue;
    const double steps = std::round(351.3 / (value * 1e-4) + noise(random));
    value = std::uint16_t(std::clamp(std::lround(351.3 / steps * 1e4), 1L, 65535L));
  }
  const int width = frame.depth.width(), height = frame.depth.height();
  std::uniform_int_distribution<int> x(0, width - 1), y(0, height - 1), size(2, 12);
  for (double missing = 0; missing < holes * width * height;) {
    const int cx = x(random), cy = y(random), r = size(random);
    for (int v = std::max(0, cy - r); v <= std::min(height - 1, cy + r); ++v) {
      for (int u = std::max(0, cx - r); u <= std::min(width - 1, cx + r); ++u) {
        if ((u - cx) * (u - cx) + (v - cy) * (v - cy) > r * r || frame.depth(u, v) == 0) continue;
        frame.depth(u, v) = 0;
        frame.state(u, v) = DepthState::kHole;
        ++missing;
      }
    }
  }
}

/// Turned about its vertical axis. Positive degrees turn it to the right.
inline Eigen::Matrix3d turned(double degrees) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

/// The eye is turned about the point at distance `z_m` in front of the first camera.
inline ViewPose orbiting_eye(int width, int height, double degrees, double z_m) {
  ViewPose eye;
  eye.intrinsics = camera_from_field_of_view(width, height, 50 * std::numbers::pi / 180);
  eye.world_from_eye.rotation = turned(degrees);
  eye.world_from_eye.translation =
      Eigen::Vector3d(0, 0, z_m) - eye.world_from_eye.rotation * Eigen::Vector3d(0, 0, z_m);
  return eye;
}

}  // namespace copresence::renderer
