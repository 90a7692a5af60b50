#include "common/frame/camera_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace copresence {
namespace {

double radial_part(const std::array<double, 8>& k, double r2) {
  const double r4 = r2 * r2, r6 = r4 * r2;
  return (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / (1 + k[5] * r2 + k[6] * r4 + k[7] * r6);
}

Eigen::Vector2d distort(const std::array<double, 8>& k, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y();
  const double r2 = x * x + y * y, radial = radial_part(k, r2);
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

Eigen::Vector2d undistort(const std::array<double, 8>& k, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector2d error = distort(k, p) - distorted;
    p -= error;
    if (error.squaredNorm() < 1e-20) break;
  }
  return p;
}

// Polynomials fitted to few corners turn around, or have a pole, where no corner was.
bool is_one_to_one(const CameraModel& camera) {
  const double reach_x = std::max(std::abs(camera.cx), std::abs(camera.width - 1 - camera.cx)) / camera.fx,
               reach_y = std::max(std::abs(camera.cy), std::abs(camera.height - 1 - camera.cy)) / camera.fy;
  const double corner = std::hypot(reach_x, reach_y);
  constexpr int kSteps = 400;
  double before = 0;
  for (int step = 1; before < corner; ++step) {
    const double r = corner * step / kSteps, r2 = r * r;
    const double pole =
        1 + camera.distortion[5] * r2 + camera.distortion[6] * r2 * r2 + camera.distortion[7] * r2 * r2 * r2;
    const double appears = r * radial_part(camera.distortion, r2);
    if (!(pole > 0) || !(appears > before) || step > 10 * kSteps) return false;
    before = appears;
  }
  // And unproject() finds the way back, all along the rim.
  constexpr int kSides = 8;
  for (int i = 0; i <= kSides; ++i) {
    const double x = (camera.width - 1.0) * i / kSides, y = (camera.height - 1.0) * i / kSides;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, 0), Eigen::Vector2d(x, camera.height - 1),
                                         Eigen::Vector2d(0, y), Eigen::Vector2d(camera.width - 1, y)}) {
      if (!((project(camera, unproject(camera, pixel, 1)) - pixel).norm() < 0.01)) return false;
    }
  }
  return true;
}

}  // namespace

bool CameraModel::is_distorted() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

CameraModel camera_from_field_of_view(int width, int height, double horizontal, double vertical) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 0.5 * width / std::tan(0.5 * horizontal);
  camera.fy = 0.5 * height / std::tan(0.5 * vertical);
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  return camera;
}

Result<void> check(const CameraModel& camera) {
  const auto fits = [](int size) { return size >= 2 && size <= 4096 && size % 2 == 0; };
  if (!fits(camera.width) || !fits(camera.height)) {
    return fail(ErrorCode::kInvalid,
                "a camera of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                    " pixels cannot be used: width and height must be even, from 2 to 4096");
  }
  const bool finite = std::isfinite(camera.fx) && std::isfinite(camera.fy) && std::isfinite(camera.cx) &&
                      std::isfinite(camera.cy) &&
                      std::all_of(camera.distortion.begin(), camera.distortion.end(),
                                  [](double k) { return std::isfinite(k); });
  if (!finite || camera.fx <= 0 || camera.fy <= 0) {
    return fail(ErrorCode::kInvalid,
                "a camera's intrinsics must be finite numbers with positive focal lengths");
  }
  if (camera.is_distorted() && !is_one_to_one(camera)) {
    return fail(
        ErrorCode::kInvalid,
        "a camera's distortion sends several rays to one pixel of its picture, or none: no lens does");
  }
  return {};
}

Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& point_in_camera) {
  assert(point_in_camera.z() > 0);
  Eigen::Vector2d p = point_in_camera.head<2>() / point_in_camera.z();
  if (camera.is_distorted()) p = distort(camera.distortion, p);
  return {camera.fx * p.x() + camera.cx, camera.fy * p.y() + camera.cy};
}

Eigen::Vector3d unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, double z_m) {
  Eigen::Vector2d p((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  if (camera.is_distorted()) p = undistort(camera.distortion, p);
  return {p.x() * z_m, p.y() * z_m, z_m};
}

std::vector<Eigen::Vector2f> rays(const CameraModel& camera) {
  std::vector<Eigen::Vector2f> out;
  out.reserve(static_cast<std::size_t>(camera.width) * camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      out.push_back(unproject(camera, {double(x), double(y)}, 1.0).head<2>().cast<float>());
    }
  }
  return out;
}

}  // namespace copresence
