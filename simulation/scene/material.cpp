#include "simulation/scene/material.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "simulation/scene/noise.h"
#include "simulation/scene/point_patterns.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// The table is indexed by the square root of light, which keeps precision in dark colours. The
// table has 2048 entries per unit.
constexpr float kSteps = 2048, kLastStep = 4096;  // The table covers light from 0 to 4.

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

// Calls paint(i, x, y) for every point i with its coordinates in cells of the pattern.
template <class Paint>
void for_each_point(const Material& m, const SurfacePoints& points, Paint&& paint) {
  const float* __restrict u = points.u.data();
  const float* __restrict v = points.v.data();
  const std::size_t n = points.u.size();
  const float scale = m.scale;
  // GCC ignores __restrict on local pointers here. The loop needs ivdep to become vector code.
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) paint(i, u[i] / scale, v[i] / scale);
}

// Multiplies the base colour by shade(x, y).
template <class Shade>
void tint(const Material& m, const SurfacePoints& points, const Colors& out, Shade&& shade) {
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const float red = m.color.x(), green = m.color.y(), blue = m.color.z();
  for_each_point(m, points, [&](std::size_t i, float x, float y) {
    const float share = shade(x, y);
    r[i] = red * share;
    g[i] = green * share;
    b[i] = blue * share;
  });
}

// Mixes base and accent colour and scales the result. shade(i, x, y) returns the share of the
// accent colour and the factor.
template <class Shade>
void blend(const Material& m, const SurfacePoints& points, const Colors& out, Shade&& shade) {
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const Vector3f one = m.color, other = m.accent;
  for_each_point(m, points, [&](std::size_t i, float x, float y) {
    const auto [share, factor] = shade(i, x, y);
    r[i] = mix_colors(one.x(), other.x(), share) * factor;
    g[i] = mix_colors(one.y(), other.y(), share) * factor;
    b[i] = mix_colors(one.z(), other.z(), share) * factor;
  });
}

void plaid(const Material& m, const SurfacePoints& points, const Colors& out) {
  static const Vector3f kLine = srgb(0xE8E0C8);
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const float* __restrict u = points.u.data();
  const float* __restrict v = points.v.data();
  const Vector3f one = m.color, other = m.accent, line_color = kLine;
  for_each_point(m, points, [&](std::size_t i, float x, float y) {
    const float across = fraction(x), along = fraction(y);
    const float broad = 0.5f * ((across < 0.45f ? 1.0f : 0.0f) + (along < 0.45f ? 1.0f : 0.0f));
    const float fine =
        0.7f * std::max(line(across - 0.72f, 0.035f, 0.02f), line(along - 0.72f, 0.035f, 0.02f));
    const float factor = 0.94f + 0.12f * value_noise(u[i] * 400, v[i] * 400, 41);
    r[i] = mix_colors(mix_colors(one.x(), other.x(), broad), line_color.x(), fine) * factor;
    g[i] = mix_colors(mix_colors(one.y(), other.y(), broad), line_color.y(), fine) * factor;
    b[i] = mix_colors(mix_colors(one.z(), other.z(), broad), line_color.z(), fine) * factor;
  });
}

// The sine of x for |x| < 1e6, with an error below 1e-12. The float is correctly rounded in all but
// one of 100,000 cases. std::sin() would keep the loop from becoming vector code.
[[gnu::always_inline]] inline float sine(float x) {
  constexpr double kInversePi = 0.31830988618379067, kPi = 3.1415926535897931,
                   kPiRest = 1.2246467991473532e-16;
  const double turns = std::floor(x * kInversePi + 0.5);
  const double r = (x - turns * kPi) - turns * kPiRest, s = r * r;
  double sum = 1.0 / 355687428096000;  // The Taylor series up to r^17.
  sum = sum * s - 1.0 / 1307674368000;
  sum = sum * s + 1.0 / 6227020800;
  sum = sum * s - 1.0 / 39916800;
  sum = sum * s + 1.0 / 362880;
  sum = sum * s - 1.0 / 5040;
  sum = sum * s + 1.0 / 120;
  sum = sum * s - 1.0 / 6;
  // `odd` is 0 for even `turns` and 2 for odd `turns`.
  const double half = 0.5 * turns, odd = 4 * (half - std::floor(half));
  return static_cast<float>((r + r * s * sum) * (1 - odd));
}

void fabric(const Material& m, const SurfacePoints& points, const Colors& out) {
  std::vector<float> threads(points.u.size());
  float* __restrict thread = threads.data();
  for_each_point(m, points, [&](std::size_t i, float x, float y) {
    thread[i] = 0.5f + 0.5f * sine(6.2832f * x) * sine(6.2832f * y);
  });
  blend(m, points, out, [&](std::size_t i, float x, float y) {
    return std::pair(0.35f * thread[i], 1 + 0.25f * mottle(x * 0.25f, y * 0.25f, 7));
  });
}

// std::hypot() would keep the loop from becoming vector code.
[[gnu::always_inline]] inline float length_of(float x, float y) {
  return static_cast<float>(std::sqrt(static_cast<double>(x) * x + static_cast<double>(y) * y));
}

// Draws a face. Coordinates are metres from the middle of the face.
void face(const Material& m, const SurfacePoints& points, const Colors& out) {
  const std::size_t n = points.u.size();
  std::vector<float> blush(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float x = std::abs(points.u[i] - 0.75f * m.scale), y = points.v[i];
    const float power = -((x - 0.04f) * (x - 0.04f) + (y + 0.145f) * (y + 0.145f)) / 0.0006f;
    blush[i] = power > -30 ? 0.5f * std::exp(power) : 0.0f;  // Smaller values vanish in a float.
  }
  const Vector3f skin = m.color, brows = m.accent, red = srgb(0xD98A70), white = srgb(0xF4F0EA),
                 iris_color = srgb(0x2A1B12), lips = srgb(0xA8504A);
  const float* __restrict cheeks = blush.data();
  const float* __restrict u = points.u.data();
  const float* __restrict v = points.v.data();
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const float x = std::abs(u[i] - 0.75f * m.scale), y = v[i];
    const float grain = 1 + 0.10f * mottle(u[i] / 0.012f, v[i] / 0.012f, 14);
    const float eye = step(1, length_of((x - 0.031f) / 0.0135f, (y + 0.188f) / 0.007f), 0.25f);
    const float iris = step(1, length_of((x - 0.031f) / 0.0062f, (y + 0.188f) / 0.0066f), 0.3f);
    const float brow = step(
        1, length_of((x - 0.032f) / 0.019f, (y + 0.207f - 6 * (x - 0.032f) * (x - 0.032f)) / 0.0035f), 0.4f);
    const float mouth = step(1, length_of(x / 0.024f, (y + 0.118f + 5 * x * x) / 0.0055f), 0.4f);
    const auto paint = [&](Eigen::Index c) {
      float color = mix_colors(skin[c], red[c], cheeks[i]) * grain;
      color = mix_colors(white[c], color, eye);
      color = mix_colors(iris_color[c], color, iris);
      color = mix_colors(brows[c], color, brow);
      return mix_colors(lips[c], color, mouth);
    };
    r[i] = paint(0);
    g[i] = paint(1);
    b[i] = paint(2);
  }
}

// Returns the share of the accent colour in wood whose grain runs along u. Coordinates are in
// cells.
inline float grain(float along, float across) {
  const float rings =
      value_noise(0.35f * along, 4 * across, 11) + 0.5f * value_noise(1.2f * along, 14 * across, 12);
  return clamp_to_unit(rings - 0.35f);
}

// Draws planks. Each plank has its own tint and its own part of the grain.
void parquet(const Material& m, const SurfacePoints& points, const Colors& out) {
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const float* __restrict u = points.u.data();
  const Vector3f one = m.color, other = m.accent;
  const float scale = m.scale;
  for_each_point(m, points, [&](std::size_t i, float, float y) {
    const float row = std::floor(y);
    const float along = u[i] / (8 * scale) + 0.37f * row;
    const std::uint32_t plank = hash(cell(along), cell(row), 5);
    const float joint = std::max(line(fraction(y + 0.5f) - 0.5f, 0.02f, 0.03f),
                                 line((fraction(along + 0.5f) - 0.5f) * 8, 0.02f, 0.03f));
    const float tint = 0.82f + 0.36f * unit(plank), share = grain((u[i] + 3 * unit(mix(plank))) / scale, y);
    const float factor = 1 - 0.55f * joint;
    r[i] = mix_colors(one.x() * tint, other.x(), share) * factor;
    g[i] = mix_colors(one.y() * tint, other.y(), share) * factor;
    b[i] = mix_colors(one.z() * tint, other.z(), share) * factor;
  });
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
  constexpr std::size_t kPixelBatch = 256;
  std::array<std::array<std::int32_t, kPixelBatch>, 3> steps;
  const std::array<const float*, 3> lights{light.r.data(), light.g.data(), light.b.data()};
  for (std::size_t first = 0; first < screen.size(); first += kPixelBatch) {
    const std::size_t n = std::min(kPixelBatch, screen.size() - first);
    for (std::size_t c = 0; c < 3; ++c) {
      const float* __restrict from = lights[c] + first;
      std::int32_t* __restrict step = steps[c].data();
      for (std::size_t i = 0; i < n; ++i) step[i] = step_of(from[i]);
    }
    for (std::size_t i = 0; i < n; ++i)
      screen[first + i] = {curve[steps[0][i]], curve[steps[1][i]], curve[steps[2][i]]};
  }
}

void albedo(const Material& m, const SurfacePoints& points, const Colors& out) {
  assert(points.v.size() == points.u.size() && out.r.size() == points.u.size() &&
         out.g.size() == points.u.size() && out.b.size() == points.u.size());
  switch (m.pattern) {
    case Pattern::kPlain:
      return tint(m, points, out, [](float x, float y) { return 1 + 0.12f * mottle(x, y, 1); });
    case Pattern::kPlaster:
      return tint(m, points, out, [](float x, float y) {
        return 1 + 0.10f * mottle(x, y, 2) + 0.06f * mottle(x * 9, y * 9, 4);
      });
    case Pattern::kHair:
      return tint(m, points, out,
                  [](float x, float y) { return 0.6f + 0.8f * value_noise(x, 0.15f * y, 10); });
    case Pattern::kFabric:
      return fabric(m, points, out);
    case Pattern::kWood:
      return blend(m, points, out,
                   [](std::size_t, float x, float y) { return std::pair(grain(x, y), 1.0f); });
    case Pattern::kParquet:
      return parquet(m, points, out);
    case Pattern::kPlaid:
      return plaid(m, points, out);
    case Pattern::kFace:
      return face(m, points, out);
    default:
      for (std::size_t i = 0; i < points.u.size(); ++i) {
        const Vector3f color = color_at_point(m, {points.u[i], points.v[i]});
        out.r[i] = color.x();
        out.g[i] = color.y();
        out.b[i] = color.z();
      }
  }
}

Vector3f albedo(const Material& material, const Vector2f& uv) {
  Vector3f color;
  albedo(material, {{&uv.x(), 1}, {&uv.y(), 1}}, {{&color.x(), 1}, {&color.y(), 1}, {&color.z(), 1}});
  return color;
}

}  // namespace copresence::simulation
