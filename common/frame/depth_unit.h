#pragma once

// The unit, the used range and the noise of a stream's depth values.

#include <cstdint>

namespace copresence {

/// Micrometres per unit of a 16-bit depth value.
enum class DepthUnit : std::uint16_t { k100Micrometres = 100, kMillimetre = 1000 };

constexpr double metres_per_unit(DepthUnit unit) {
  return static_cast<double>(unit) * 1e-6;
}

/// Depth outside [near, far] counts as a hole. In metres; 0 < near_m < far_m.
struct DepthRange {
  double near_m = 0.4;
  double far_m = 5.0;
  friend bool operator==(const DepthRange&, const DepthRange&) = default;
};

/// A range in the stream's unit. Depth values v with near <= v <= far are kept. Requires 1 <= near
/// <= far <= 65535.
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

/// Resolution and noise of a sensor that triangulates (structured light, stereo). Such a sensor
/// measures disparity in steps of equal size. The disparity of depth z is disparity_constant_m / z
/// steps. So depth levels are evenly spaced in 1/z, and the distance between neighbours grows with
/// z². Most depth thresholds are in steps. Sensors without a disparity (time of flight) use the
/// constant that fits best in the middle of their range. The default is a Kinect v1.
/// Source: Khoshelham and Elberink 2012 (form), Barron and Malik 2013 (the Kinect's constant).
struct DepthNoise {
  /// Focal length times baseline, divided by the disparity step. In metres, from 50 to 1e5.
  double disparity_constant_m = 351.3;
  /// Standard deviation of a depth value, in steps. From 0.01 to 100.
  double sigma_steps = 0.5;

  /// Size of a step in 1/z, in 1/m. This size is the same at every depth.
  constexpr double inverse_step() const { return 1 / disparity_constant_m; }
  /// Size of a step at depth z, in metres.
  constexpr double step_m(double z_m) const { return z_m * z_m / disparity_constant_m; }
  /// Standard deviation at depth z, in metres.
  constexpr double sigma_m(double z_m) const { return sigma_steps * step_m(z_m); }

  friend bool operator==(const DepthNoise&, const DepthNoise&) = default;
};

inline constexpr DepthNoise kKinectV1Noise{};

}  // namespace copresence
