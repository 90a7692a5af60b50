#pragma once

// The unit of a stream's depth values and the part of their range that is used; and what a Kinect's depth is
// worth.

#include <cmath>
#include <cstdint>

namespace copresence {

/// Micrometres per unit of a 16-bit depth value.
enum class DepthUnit : std::uint16_t { k100Micrometres = 100, kMillimetre = 1000 };

constexpr double metres_per_unit(DepthUnit unit) {
  return static_cast<double>(unit) * 1e-6;
}

/// Depth outside [near, far] counts as a hole. Metres; 0 < near_m < far_m.
struct DepthRange {
  double near_m = 0.4;
  double far_m = 5.0;
  friend bool operator==(const DepthRange&, const DepthRange&) = default;
};

/// A range in the stream's unit: the depth values v with near <= v <= far are kept. 1 <= near <= far <=
/// 65535.
struct DepthRangeUnits {
  std::uint16_t near = 0;
  std::uint16_t far = 0;
  constexpr bool contains(std::uint16_t value) const { return value >= near && value <= far; }
};

constexpr DepthRangeUnits to_units(const DepthRange& range, DepthUnit unit) {
  const double per_metre = 1.0 / metres_per_unit(unit);
  const auto clamp = [](double v) {
    return static_cast<std::uint16_t>(v < 1.0 ? 1.0 : v > 65535.0 ? 65535.0 : v + 0.5);
  };
  return {clamp(range.near_m * per_metre), clamp(range.far_m * per_metre)};
}

/// Distance between neighbouring depth levels of a Kinect v1 at depth z, both in metres: z^2 / 351.3 m.
/// Source: Khoshelham and Elberink 2012, equation for the depth resolution, with the constant of Barron and
/// Malik 2013.
constexpr double sensor_step_m(double z_m) {
  return z_m * z_m / 351.3;
}

/// Standard deviation of a Kinect v1's depth at depth z, both in metres: half a step.
constexpr double sensor_sigma_m(double z_m) {
  return 0.5 * sensor_step_m(z_m);
}

}  // namespace copresence
