#include "tools/depth_bench/holoimage.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace copresence::depth_bench {
namespace {

constexpr double kPi = std::numbers::pi;
// Neighbours whose depth differs by more than this are separate surfaces. The gap between separate
// surfaces casts no shadow.
constexpr double kDiscontinuityM = 0.1;
constexpr double kShadowTolerance = 2;  // In pixels; keeps a surface from shading itself through rounding.

std::uint8_t to_sample(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

double fraction(double value) {
  return value - std::floor(value);
}

// The wave within a stair, K = 0 in equation 2.6. The wave does not jump between stairs.
double wave(double stair, double phase) {
  return stair / 2 - (stair - 2) / 2 * std::cos(kPi * phase);
}

}  // namespace

Holoimage::Holoimage(const depth::DepthFormat& format) : format_(format) {
  const double unit = metres_per_unit(format.unit), angle = kProjectorDegrees / 180 * kPi;
  pixel_ = kPixelM / unit;
  sine_ = std::sin(angle);
  cosine_ = std::cos(angle);
  width_ = kFringeWidthM / unit;
  first_ = fringe_coordinate(0, format.units().near);
  const double fringes = std::ceil((fringe_coordinate(format.width, format.units().far) - first_) / width_);
  stair_ = 255 / (fringes + 1);  // The lowest stair is black.
}

double Holoimage::fringe_coordinate(double x, double z) const {
  return x * pixel_ * cosine_ + z * sine_;
}

std::vector<bool> Holoimage::find_lit_pixels(const DepthImage& depth) const {
  std::vector<bool> lit(depth.pixels().size());
  const auto rays = static_cast<std::size_t>(
      std::ceil((fringe_coordinate(format_.width, format_.units().far) - first_) / (pixel_ * cosine_)) + 2);
  std::vector<double> nearest(rays);  // Distance to the first surface along each projector ray.
  const auto ray = [&](double fringe) { return (fringe - first_) / (pixel_ * cosine_); };
  const auto distance = [&](int x, double z) { return z * cosine_ - x * pixel_ * sine_; };
  const double gap = kDiscontinuityM / metres_per_unit(format_.unit);
  for (int y = 0; y < depth.height(); ++y) {
    const std::span<const std::uint16_t> row = depth.row(y);
    std::fill(nearest.begin(), nearest.end(), std::numeric_limits<double>::infinity());
    for (int x = 0; x < depth.width(); ++x) {
      if (row[x] == 0) continue;
      const bool joined = x > 0 && row[x - 1] != 0 && std::abs(int(row[x]) - int(row[x - 1])) <= gap;
      const double to = ray(fringe_coordinate(x, row[x])), to_distance = distance(x, row[x]);
      const double from = joined ? ray(fringe_coordinate(x - 1, row[x - 1])) : to;
      const double from_distance = joined ? distance(x - 1, row[x - 1]) : to_distance;
      for (auto i = std::lround(std::min(from, to)); i <= std::lround(std::max(from, to)); ++i) {
        const double share = to == from ? 1 : std::clamp((double(i) - from) / (to - from), 0.0, 1.0);
        double& first = nearest[static_cast<std::size_t>(i)];
        first = std::min(first, from_distance + share * (to_distance - from_distance));
      }
    }
    for (int x = 0; x < depth.width(); ++x) {
      if (row[x] == 0) continue;
      const auto i = static_cast<std::size_t>(std::lround(ray(fringe_coordinate(x, row[x]))));
      lit[static_cast<std::size_t>(y) * depth.width() + x] =
          distance(x, row[x]) <= nearest[i] + kShadowTolerance * pixel_;
    }
  }
  return lit;
}

Picture Holoimage::encode(const DepthImage& depth) const {
  assert(depth.width() == format_.width && depth.height() == format_.height);
  Picture picture(PixelFormat::kYuv444, depth.width(), depth.height());
  const auto luma = picture.plane8(0), u = picture.plane8(1), v = picture.plane8(2);
  const std::vector<bool> lit = find_lit_pixels(depth);
  for (std::size_t i = 0; i < lit.size(); ++i) {
    u[i] = v[i] = 128;
    if (!lit[i]) continue;
    const auto x = static_cast<double>(i % static_cast<std::size_t>(format_.width));
    const double fringes = (fringe_coordinate(x, depth.data()[i]) - first_) / width_,
                 phase = fraction(fringes);
    luma[i] = to_sample(stair_ * (std::floor(fringes) + 1) + wave(stair_, phase));
    u[i] = to_sample(127.5 * (1 + std::sin(2 * kPi * phase)));
    v[i] = to_sample(127.5 * (1 + std::cos(2 * kPi * phase)));
  }
  return picture;
}

void Holoimage::decode(const Picture& picture, DepthImage& depth) const {
  assert(picture.format() == PixelFormat::kYuv444 && picture.width() == depth.width());
  const auto luma = picture.plane8(0), u = picture.plane8(1), v = picture.plane8(2);
  const DepthRangeUnits range = format_.units();
  for (std::size_t i = 0; i < luma.size(); ++i) {
    if (luma[i] < stair_ / 2) {
      depth.data()[i] = 0;
      continue;
    }
    const double phase = fraction(std::atan2(u[i] / 127.5 - 1, v[i] / 127.5 - 1) / (2 * kPi));
    const double count = std::round((luma[i] - wave(stair_, phase)) / stair_ - 1);
    const auto x = static_cast<double>(i % static_cast<std::size_t>(format_.width));
    const double fringe = first_ + width_ * (count + phase);
    const double z = (fringe - x * pixel_ * cosine_) / sine_;
    depth.data()[i] = static_cast<std::uint16_t>(std::lround(std::clamp<double>(z, range.near, range.far)));
  }
}

}  // namespace copresence::depth_bench
