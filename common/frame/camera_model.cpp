#include "common/frame/camera_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace copresence {
namespace {

// The radial distortion is a quotient of two polynomials in r2, the squared distance from the axis.
struct Quotient {
  double above, below;
};

Quotient radial_quotient(const std::array<double, 8>& k, double r2) {
  const double r4 = r2 * r2, r6 = r4 * r2;
  return {1 + k[0] * r2 + k[1] * r4 + k[4] * r6, 1 + k[5] * r2 + k[6] * r4 + k[7] * r6};
}

double radial_part(const std::array<double, 8>& k, double r2) {
  const Quotient quotient = radial_quotient(k, r2);
  return quotient.above / quotient.below;
}

Eigen::Vector2d distort(const std::array<double, 8>& k, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y();
  const double r2 = x * x + y * y, radial = radial_part(k, r2);
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

// The derivatives of distort(), a symmetric matrix. `is_regular` is true if the distortion is
// one-to-one around the point.
struct Jacobian {
  double xx, xy, yy;
  bool is_regular;

  Jacobian(const std::array<double, 8>& k, const Eigen::Vector2d& p) {
    const double x = p.x(), y = p.y(), r2 = x * x + y * y, r4 = r2 * r2;
    const Quotient quotient = radial_quotient(k, r2);
    const double radial = quotient.above / quotient.below;
    const double by_r2 =
        (k[0] + 2 * k[1] * r2 + 3 * k[4] * r4 - radial * (k[5] + 2 * k[6] * r2 + 3 * k[7] * r4)) /
        quotient.below;
    xx = radial + 2 * by_r2 * x * x + 2 * k[2] * y + 6 * k[3] * x;
    yy = radial + 2 * by_r2 * y * y + 6 * k[2] * y + 2 * k[3] * x;
    xy = 2 * by_r2 * x * y + 2 * k[2] * x + 2 * k[3] * y;
    is_regular = quotient.below > 0 && determinant() > 0;
  }
  double determinant() const { return xx * yy - xy * xy; }
  Eigen::Vector2d solve(const Eigen::Vector2d& b) const {
    return Eigen::Vector2d(yy * b.x() - xy * b.y(), xx * b.y() - xy * b.x()) / determinant();
  }
};

// Inverts distort() by Newton's method, starting at the optical axis. Each step is halved until it
// reduces the error and stays where the distortion is one-to-one. Where the distortion folds, two
// rays lead to the same pixel; this finds the ray before the fold. If no ray leads to the pixel,
// the result is the best point found.
Eigen::Vector2d undistort(const std::array<double, 8>& k, const Eigen::Vector2d& distorted) {
  constexpr int kSteps = 50, kHalvings = 20;
  constexpr double kExact = 1e-24;  // Squared error; 1e-9 px at a focal length of 1000 px.
  Eigen::Vector2d p(0, 0), error = -distorted;
  for (int i = 0; i < kSteps && error.squaredNorm() > kExact; ++i) {
    Eigen::Vector2d step = Jacobian(k, p).solve(error);
    bool accepted = false;
    for (int halving = 0; halving < kHalvings && !accepted; ++halving, step *= 0.5) {
      const Eigen::Vector2d next = p - step, error_there = distort(k, next) - distorted;
      accepted = error_there.squaredNorm() < error.squaredNorm() && Jacobian(k, next).is_regular;
      if (!accepted) continue;
      p = next;
      error = error_there;
    }
    if (!accepted) break;
  }
  return p;
}

// True if the polynomial, the sum of c[i] x^i, is positive everywhere in [0, end], up to rounding.
// If all Bernstein coefficients are positive, the polynomial is positive. Otherwise the interval is
// halved and both halves are tested.
template <std::size_t kSize>
bool is_positive(const std::array<double, kSize>& c, double end) {
  const auto bernstein_positive = [](const std::array<double, kSize>& b, int depth,
                                     const auto& self) -> bool {
    if (!(b.front() > 0) || !(b.back() > 0)) return false;
    if (std::all_of(b.begin(), b.end(), [](double value) { return value > 0; })) return true;
    if (depth == 0) return false;
    std::array<double, kSize> left{}, right = b;  // Subdivision by de Casteljau.
    for (std::size_t i = 0; i < kSize; ++i) {
      left[i] = right[0];
      for (std::size_t j = 0; j + i + 1 < kSize; ++j) right[j] = 0.5 * (right[j] + right[j + 1]);
    }
    return self(left, depth - 1, self) && self(right, depth - 1, self);
  };
  std::array<double, kSize> b{}, scaled = c;
  for (std::size_t i = 1; i < kSize; ++i) {
    for (std::size_t j = i; j < kSize; ++j) scaled[j] *= end;
  }
  for (std::size_t i = 0; i < kSize; ++i) {
    // b[i] = sum over j <= i of (i choose j) / (degree choose j) * scaled[j].
    double ratio = 1;
    for (std::size_t j = 0; j <= i; ++j) {
      b[i] += ratio * scaled[j];
      if (j < i) ratio *= static_cast<double>(i - j) / static_cast<double>(kSize - 1 - j);
    }
  }
  constexpr int kDepth = 40;
  return bernstein_positive(b, kDepth, bernstein_positive);
}

// True if, up to distance r from the axis, the radial distortion has no pole and a derivative
// between 0 and kMostStretch. The distortion is r A(x) / B(x), where x = r^2 and the polynomials A
// and B have the coefficients `a` and `b`. The derivative is (A B + 2 x (A' B - A B')) / B^2.
bool grows_smoothly(const std::array<double, 8>& k, double r) {
  // Real lenses magnify the rim of the picture at most about twice as much as its middle.
  constexpr double kMostStretch = 4;
  const std::array<double, 4> a{1, k[0], k[1], k[4]}, b{1, k[5], k[6], k[7]};
  std::array<double, 7> growth{}, room{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double term = a[i] * b[j] * (1 + 2 * (static_cast<double>(i) - static_cast<double>(j)));
      growth[i + j] += term;
      room[i + j] += kMostStretch * b[i] * b[j] - term;
    }
  }
  const double end = r * r;
  return is_positive(b, end) && is_positive(growth, end) && is_positive(room, end);
}

// True if different rays lead to different pixels. A polynomial that was fitted to few corners may
// fold, or have a pole, in parts of the picture without corners.
bool is_one_to_one(const CameraModel& camera) {
  const double reach_x = std::max(std::abs(camera.cx), std::abs(camera.width - 1 - camera.cx)) / camera.fx,
               reach_y = std::max(std::abs(camera.cy), std::abs(camera.height - 1 - camera.cy)) / camera.fy;
  // Distance from the axis at which the ray of the picture's farthest corner passes, without
  // tangential distortion.
  const double corner = std::hypot(reach_x, reach_y);
  constexpr int kSteps = 100, kFarthest = 10 * kSteps;
  int step = 1;
  const auto appears = [&](int at) {
    const double r = corner * at / kSteps;
    return r * radial_part(camera.distortion, r * r);
  };
  while (step < kFarthest && !(appears(step) >= corner)) ++step;
  if (step == kFarthest || !grows_smoothly(camera.distortion, corner * step / kSteps)) return false;
  // Tangential distortion can fold the picture, too. So unproject() must invert project() all along
  // the rim.
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

CameraModel camera_from_field_of_view(int width, int height, double vertical) {
  CameraModel camera = camera_from_field_of_view(width, height, vertical, vertical);
  camera.fx = camera.fy;
  return camera;
}

CameraModel nominal_kinect(int width, int height) {
  constexpr double kLongerSide = 1.0144686;  // Radians.
  const double focal = 0.5 * std::max(width, height) / std::tan(0.5 * kLongerSide);
  return camera_from_field_of_view(width, height, 2 * std::atan(0.5 * height / focal));
}

CameraModel camera_of_sensor(int width, int height, double horizontal, double vertical) {
  constexpr double kMostOutOfSquare = 0.05;
  CameraModel camera = camera_from_field_of_view(width, height, horizontal, vertical);
  if (std::abs(camera.fx / camera.fy - 1) > kMostOutOfSquare) {
    const double focal = width >= height ? camera.fx : camera.fy;
    camera.fx = camera.fy = focal;
  }
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
  const auto plausible = [](double focal, double centre, int size) {
    constexpr double kShortest = 1e-3, kLongest = 1e4, kFarthest = 100;  // In units of the picture's size.
    return focal >= kShortest * size && focal <= kLongest * size && std::abs(centre) <= kFarthest * size;
  };
  if (!plausible(camera.fx, camera.cx, camera.width) || !plausible(camera.fy, camera.cy, camera.height)) {
    return fail(ErrorCode::kInvalid,
                "a camera's focal lengths and principal point are in pixels: these values are impossible for "
                "a picture "
                "of " +
                    std::to_string(camera.width) + "x" + std::to_string(camera.height));
  }
  if (camera.is_distorted() && !is_one_to_one(camera)) {
    return fail(ErrorCode::kInvalid,
                "a camera's distortion sends several rays to one pixel of its picture, or none: are the "
                "coefficients in OpenCV's order, k1 k2 p1 p2 k3 k4 k5 k6?");
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
