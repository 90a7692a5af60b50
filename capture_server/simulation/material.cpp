#include "capture_server/simulation/material.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture_server/simulation/hash_noise.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

Vector3f mix_colors(const Vector3f& a, const Vector3f& b, float share) {
  return a + (b - a) * share;
}

float fraction(float x) {
  return x - std::floor(x);
}

std::uint32_t cell(float x) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(x)));
}

// 0 below the edge, 1 above, a ramp `width` wide between.
float step(float edge, float x, float width) {
  return std::clamp((x - edge) / width + 0.5f, 0.0f, 1.0f);
}

// 1 on a line of the given half width around 0.
float line(float x, float half_width, float soft) {
  return 1 - step(half_width, std::abs(x), soft);
}

float mottle(const Vector2f& p, std::uint32_t seed) {
  return 0.6f * value_noise(p.x(), p.y(), seed) + 0.4f * value_noise(2.3f * p.x(), 2.3f * p.y(), seed + 1) -
         0.5f;
}

Vector3f wood(const Material& m, const Vector2f& uv) {
  const float along = uv.x() / m.scale, across = uv.y() / m.scale;
  const float rings =
      value_noise(0.35f * along, 4 * across, 11) + 0.5f * value_noise(1.2f * along, 14 * across, 12);
  return mix_colors(m.color, m.accent, std::clamp(rings - 0.35f, 0.0f, 1.0f));
}

Vector3f parquet(const Material& m, const Vector2f& uv) {
  const float row = std::floor(uv.y() / m.scale);
  const float along = uv.x() / (8 * m.scale) + 0.37f * row;
  const std::uint32_t plank = hash(cell(along), cell(row), 5);
  const float joint = std::max(line(fraction(uv.y() / m.scale + 0.5f) - 0.5f, 0.02f, 0.03f),
                               line((fraction(along + 0.5f) - 0.5f) * 8, 0.02f, 0.03f));
  Material tinted = m;
  tinted.color = m.color * (0.82f + 0.36f * unit(plank));
  const Vector2f shifted(uv.x() + 3 * unit(mix(plank)), uv.y());
  return wood(tinted, shifted) * (1 - 0.55f * joint);
}

Vector3f rug(const Material& m, const Vector2f& uv) {
  const float edge = std::min({uv.x(), 1 - uv.x(), uv.y(), 1 - uv.y()});
  const Vector3f cream = srgb(0xE3D5B8);
  const float weave = 0.9f + 0.2f * unit(hash(cell(uv.x() * 160), cell(uv.y() * 120), 3));
  if (edge < 0.03f) return cream * weave;
  if (edge < 0.10f) {
    const bool tooth = (cell(uv.x() * 40) + cell(uv.y() * 28)) % 2 == 0;
    return (tooth ? m.accent : m.color) * weave;
  }
  if (edge < 0.12f) return cream * weave;
  const float a = fraction(uv.x() * 6) - 0.5f, b = fraction(uv.y() * 4) - 0.5f;
  const float diamond = std::abs(a) + std::abs(b);
  const Vector3f inside = diamond < 0.16f   ? cream
                          : diamond < 0.30f ? m.accent
                          : diamond < 0.36f ? cream
                                            : m.color;
  return inside * weave;
}

Vector3f picture(const Vector2f& uv) {
  const float x = uv.x(), y = uv.y();
  if (x < 0.06f || x > 0.94f || y < 0.08f || y > 0.92f) return srgb(0xEFE9DC);  // mount
  const float sun = std::hypot(x - 0.68f, (y - 0.30f) * 0.75f);
  Vector3f color = mix_colors(srgb(0x3F6FA8), srgb(0xF4B36A), std::clamp((y - 0.05f) / 0.5f, 0.0f, 1.0f));
  color = mix_colors(color, srgb(0xFFF0C0), 1 - step(0.07f, sun, 0.01f));
  const float far_hill = 0.52f - 0.10f * value_noise(4 * x, 0.5f, 21);
  const float near_hill = 0.66f - 0.16f * value_noise(3 * x + 7, 1.5f, 22);
  if (y > far_hill) color = srgb(0x55718A);
  if (y > near_hill) color = mix_colors(srgb(0x2F5D3A), srgb(0x6B8F3F), value_noise(18 * x, 26 * y, 23));
  if (y > 0.80f)
    color = mix_colors(srgb(0x2C5C86), srgb(0xD9C79A), step(0.6f, value_noise(9 * x, 60 * y, 24), 0.2f));
  return color;
}

Vector3f poster(const Vector2f& uv) {
  static const std::array<std::uint32_t, 5> kInks{0xD1495B, 0xEDAE49, 0x00798C, 0x30638E, 0x2B2D42};
  Vector3f color = srgb(0xF2EBDD);
  for (std::uint32_t i = 0; i < 9; ++i) {
    const Vector2f center(0.12f + 0.76f * unit(mix(7 * i + 1)), 0.12f + 0.6f * unit(mix(7 * i + 2)));
    const float radius = 0.05f + 0.12f * unit(mix(7 * i + 3));
    const float distance = std::hypot(uv.x() - center.x(), (uv.y() - center.y()) * 1.4f);
    if (std::abs(distance - radius) < 0.02f || distance < 0.5f * radius)
      color = srgb(kInks[i % kInks.size()]);
  }
  if (uv.y() > 0.82f && uv.y() < 0.93f && uv.x() > 0.1f && uv.x() < 0.9f) {
    const float letter = fraction(uv.x() * 14);
    if (letter < 0.7f && unit(hash(cell(uv.x() * 42), cell(uv.y() * 50), 9)) > 0.35f) color = srgb(0x2B2D42);
  }
  return color;
}

Vector3f outdoors(const Vector2f& uv) {
  const float cloud =
      0.6f * value_noise(5 * uv.x(), 9 * uv.y(), 31) + 0.4f * value_noise(12 * uv.x(), 20 * uv.y(), 32);
  const Vector3f sky = mix_colors(srgb(0x9CC4EE), srgb(0xFFFFFF), step(0.55f, cloud, 0.4f));
  const float tree_line =
      0.66f - 0.20f * value_noise(6 * uv.x(), 0, 33) - 0.05f * value_noise(25 * uv.x(), 0, 34);
  if (uv.y() < tree_line) return sky;
  return mix_colors(srgb(0x3C5A2C), srgb(0x8FA85A), value_noise(30 * uv.x(), 30 * uv.y(), 35));
}

Vector3f plaid(const Material& m, const Vector2f& uv) {
  const float a = fraction(uv.x() / m.scale), b = fraction(uv.y() / m.scale);
  const float broad = 0.5f * (float(a < 0.45f) + float(b < 0.45f));
  const float fine = std::max(line(a - 0.72f, 0.035f, 0.02f), line(b - 0.72f, 0.035f, 0.02f));
  Vector3f color = mix_colors(m.color, m.accent, broad);
  color = mix_colors(color, srgb(0xE8E0C8), 0.7f * fine);
  return color * (0.94f + 0.12f * value_noise(uv.x() * 400, uv.y() * 400, 41));
}

// Measured in metres from the middle of the face.
Vector3f face(const Material& m, const Vector2f& uv) {
  const float x = std::abs(uv.x() - 0.75f * m.scale), y = uv.y();
  const float cheeks = std::exp(-((x - 0.04f) * (x - 0.04f) + (y + 0.145f) * (y + 0.145f)) / 0.0006f);
  Vector3f color = mix_colors(m.color, srgb(0xD98A70), 0.5f * cheeks) * (1 + 0.10f * mottle(uv / 0.012f, 14));
  const float eye = std::hypot((x - 0.031f) / 0.0135f, (y + 0.188f) / 0.007f);
  const float iris = std::hypot((x - 0.031f) / 0.0062f, (y + 0.188f) / 0.0066f);
  color = mix_colors(srgb(0xF4F0EA), color, step(1, eye, 0.25f));
  color = mix_colors(srgb(0x2A1B12), color, step(1, iris, 0.3f));
  const float brow =
      std::hypot((x - 0.032f) / 0.019f, (y + 0.207f - 6 * (x - 0.032f) * (x - 0.032f)) / 0.0035f);
  color = mix_colors(m.accent, color, step(1, brow, 0.4f));
  const float mouth = std::hypot(x / 0.024f, (y + 0.118f + 5 * x * x) / 0.0055f);
  return mix_colors(srgb(0xA8504A), color, step(1, mouth, 0.4f));
}

}  // namespace

Vector3f srgb(std::uint32_t hex) {
  const auto linear = [](std::uint32_t byte) {
    const float c = static_cast<float>(byte & 0xFF) / 255.0f;
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  };
  return {linear(hex >> 16), linear(hex >> 8), linear(hex)};
}

Rgb8 to_screen(const Vector3f& light) {
  // 4096 steps of the curve, square-root spaced so that the dark end keeps its steps.
  static const auto kCurve = [] {
    std::array<std::uint8_t, 4097> curve{};
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const double root = static_cast<double>(i) / 2048.0, x = root * root;  // light from 0 to 4
      const double soft = x <= 0.8 ? x : 0.8 + 0.2 * (1 - std::exp(-(x - 0.8) / 0.2));
      const double coded = soft <= 0.0031308 ? 12.92 * soft : 1.055 * std::pow(soft, 1 / 2.4) - 0.055;
      curve[i] = static_cast<std::uint8_t>(std::lround(255 * coded));
    }
    return curve;
  }();
  const auto code = [&](float x) {
    return kCurve[static_cast<std::size_t>(std::min(std::sqrt(std::max(x, 0.0f)) * 2048.0f, 4096.0f))];
  };
  return {code(light.x()), code(light.y()), code(light.z())};
}

Vector3f albedo(const Material& m, const Vector2f& uv) {
  const Vector2f p = uv / m.scale;
  switch (m.pattern) {
    case Pattern::kPlain:
      return m.color * (1 + 0.12f * mottle(p, 1));
    case Pattern::kPlaster:
      return m.color * (1 + 0.10f * mottle(p, 2) + 0.06f * mottle(p * 9, 4));
    case Pattern::kWallpaper: {
      const float stripe = step(0.5f, std::abs(fraction(p.x()) - 0.5f) * 2, 0.06f);
      const float diamond = std::abs(fraction(p.x() + 0.5f) - 0.5f) + 0.6f * std::abs(fraction(p.y()) - 0.5f);
      const Vector3f ground = mix_colors(m.color, m.accent, 0.35f * stripe);
      return mix_colors(ground, m.accent, 0.8f * (1 - step(0.12f, diamond, 0.04f))) *
             (1 + 0.05f * mottle(p * 7, 6));
    }
    case Pattern::kWood:
      return wood(m, uv);
    case Pattern::kParquet:
      return parquet(m, uv);
    case Pattern::kRug:
      return rug(m, uv);
    case Pattern::kFabric: {
      const float thread = 0.5f + 0.5f * std::sin(6.2832f * p.x()) * std::sin(6.2832f * p.y());
      return mix_colors(m.color, m.accent, 0.35f * thread) * (1 + 0.25f * mottle(p * 0.25f, 7));
    }
    case Pattern::kBook: {
      const float v = fraction(p.y());
      const bool band = (v > 0.10f && v < 0.15f) || (v > 0.84f && v < 0.88f);
      const bool title = v > 0.30f && v < 0.68f && unit(hash(cell(p.y() * 40), cell(p.x() * 9), 8)) > 0.55f;
      return band || title ? m.accent : m.color * (1 + 0.15f * mottle(p * 6, 8));
    }
    case Pattern::kPicture:
      return picture(uv);
    case Pattern::kPoster:
      return poster(uv);
    case Pattern::kOutdoors:
      return outdoors(uv);
    case Pattern::kLeaf:
      return mix_colors(m.color, m.accent, line(uv.x(), 0.06f, 0.08f)) *
             (0.8f + 0.4f * value_noise(p.x(), p.y(), 9));
    case Pattern::kPlaid:
      return plaid(m, uv);
    case Pattern::kStripes:
      return fraction(p.y()) < 0.5f ? m.color : m.accent;
    case Pattern::kFace:
      return face(m, uv);
    case Pattern::kHair:
      return m.color * (0.6f + 0.8f * value_noise(p.x(), 0.15f * p.y(), 10));
  }
  return m.color;
}

}  // namespace copresence::simulation
