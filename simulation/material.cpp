#include "simulation/material.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace copresence::simulation {

using Eigen::Vector3f;

namespace {

// What a screen needs for light, 2048 steps to its square root so that the dark end keeps its steps.
constexpr float kSteps = 2048, kLastStep = 4096;  // light from 0 to 4

const std::uint8_t* screen_curve() {
  static const auto kCurve = [] {
    std::array<std::uint8_t, 4097> curve{};
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const double root = static_cast<double>(i) / kSteps, x = root * root;
      const double soft = x <= 0.8 ? x : 0.8 + 0.2 * (1 - std::exp(-(x - 0.8) / 0.2));
      const double coded = soft <= 0.0031308 ? 12.92 * soft : 1.055 * std::pow(soft, 1 / 2.4) - 0.055;
      curve[i] = static_cast<std::uint8_t>(std::lround(255 * coded));
    }
    return curve;
  }();
  return kCurve.data();
}

std::int32_t step_of(float light) {
  return static_cast<std::int32_t>(std::min(std::sqrt(std::max(light, 0.0f)) * kSteps, kLastStep));
}

}  // namespace

Vector3f srgb(std::uint32_t hex) {
  static const auto kLinear = [] {
    std::array<float, 256> linear{};
    for (std::size_t byte = 0; byte < linear.size(); ++byte) {
      const float c = static_cast<float>(byte) / 255.0f;
      linear[byte] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
    }
    return linear;
  }();
  return {kLinear[hex >> 16 & 0xFF], kLinear[hex >> 8 & 0xFF], kLinear[hex & 0xFF]};
}

Rgb8 to_screen(const Vector3f& light) {
  const std::uint8_t* curve = screen_curve();
  return {curve[step_of(light.x())], curve[step_of(light.y())], curve[step_of(light.z())]};
}

void to_screen(const Colors& light, std::span<Rgb8> screen) {
  const std::uint8_t* curve = screen_curve();
  constexpr std::size_t kTogether = 256;
  std::array<std::array<std::int32_t, kTogether>, 3> steps;
  const std::array<const float*, 3> lights{light.r.data(), light.g.data(), light.b.data()};
  for (std::size_t first = 0; first < screen.size(); first += kTogether) {
    const std::size_t n = std::min(kTogether, screen.size() - first);
    for (std::size_t c = 0; c < 3; ++c) {
      const float* __restrict from = lights[c] + first;
      std::int32_t* __restrict step = steps[c].data();
      for (std::size_t i = 0; i < n; ++i) step[i] = step_of(from[i]);
    }
    for (std::size_t i = 0; i < n; ++i)
      screen[first + i] = {curve[steps[0][i]], curve[steps[1][i]], curve[steps[2][i]]};
  }
}

}  // namespace copresence::simulation
