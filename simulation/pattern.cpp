// The patterns of materials. Those that cover most of a picture are computed channel by channel over many places, so
// that loops become vector code; the others place by place. Either way a place has one colour, to the last bit.

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "simulation/hash_noise.h"
#include "simulation/material.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

template <class Value>
Value mix_colors(const Value& a, const Value& b, float share) {
  return a + (b - a) * share;
}

float fraction(float x) {
  return x - std::floor(x);
}

std::uint32_t cell(float x) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(x)));
}

float between_0_and_1(float x) {
  return std::min(std::max(x, 0.0f), 1.0f);
}

// 0 below the edge, 1 above, a ramp `width` wide between.
float step(float edge, float x, float width) {
  return between_0_and_1((x - edge) / width + 0.5f);
}

// 1 on a line of the given half width around 0.
float line(float x, float half_width, float soft) {
  return 1 - step(half_width, std::abs(x), soft);
}

inline float mottle(float x, float y, std::uint32_t seed) {
  return 0.6f * value_noise(x, y, seed) + 0.4f * value_noise(2.3f * x, 2.3f * y, seed + 1) - 0.5f;
}

// Calls paint(place, x, y) with each place's coordinates in cells of the pattern.
template <class Paint>
void for_each_place(const Material& m, const Places& places, Paint&& paint) {
  const float* __restrict u = places.u.data();
  const float* __restrict v = places.v.data();
  const std::size_t n = places.u.size();
  const float scale = m.scale;
  // GCC takes no local pointer's word for it that nothing overlaps.
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) paint(i, u[i] / scale, v[i] / scale);
}

// One colour, lighter and darker by place.
template <class Shade>
void tint(const Material& m, const Places& places, const Colors& out, Shade&& shade) {
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const float red = m.color.x(), green = m.color.y(), blue = m.color.z();
  for_each_place(m, places, [&](std::size_t i, float x, float y) {
    const float share = shade(x, y);
    r[i] = red * share;
    g[i] = green * share;
    b[i] = blue * share;
  });
}

// Two colours mixed by place, then lighter and darker: shade(x, y) gives the share of the second and the factor.
template <class Shade>
void blend(const Material& m, const Places& places, const Colors& out, Shade&& shade) {
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const Vector3f one = m.color, other = m.accent;
  for_each_place(m, places, [&](std::size_t i, float x, float y) {
    const auto [share, factor] = shade(i, x, y);
    r[i] = mix_colors(one.x(), other.x(), share) * factor;
    g[i] = mix_colors(one.y(), other.y(), share) * factor;
    b[i] = mix_colors(one.z(), other.z(), share) * factor;
  });
}

void plaid(const Material& m, const Places& places, const Colors& out) {
  static const Vector3f kLine = srgb(0xE8E0C8);
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const float* __restrict u = places.u.data();
  const float* __restrict v = places.v.data();
  const Vector3f one = m.color, other = m.accent, line_color = kLine;
  for_each_place(m, places, [&](std::size_t i, float x, float y) {
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

// Within 1e-12 of the sine of |x| < 1e6, so that its float is the nearest one but for one place in a hundred thousand. Unlike
// the library's it becomes vector code.
[[gnu::always_inline]] inline float sine(float x) {
  constexpr double kInversePi = 0.31830988618379067, kPi = 3.1415926535897931,
                   kPiRest = 1.2246467991473532e-16;
  const double turns = std::floor(x * kInversePi + 0.5);
  const double r = (x - turns * kPi) - turns * kPiRest, s = r * r;
  double sum = 1.0 / 355687428096000;  // the series to r^17
  sum = sum * s - 1.0 / 1307674368000;
  sum = sum * s + 1.0 / 6227020800;
  sum = sum * s - 1.0 / 39916800;
  sum = sum * s + 1.0 / 362880;
  sum = sum * s - 1.0 / 5040;
  sum = sum * s + 1.0 / 120;
  sum = sum * s - 1.0 / 6;
  const double half = 0.5 * turns, odd = 4 * (half - std::floor(half));  // 0 or 2
  return static_cast<float>((r + r * s * sum) * (1 - odd));
}

// A coarse weave.
void fabric(const Material& m, const Places& places, const Colors& out) {
  std::vector<float> threads(places.u.size());
  float* __restrict thread = threads.data();
  for_each_place(m, places, [&](std::size_t i, float x, float y) {
    thread[i] = 0.5f + 0.5f * sine(6.2832f * x) * sine(6.2832f * y);
  });
  blend(m, places, out, [&](std::size_t i, float x, float y) {
    return std::pair(0.35f * thread[i], 1 + 0.25f * mottle(x * 0.25f, y * 0.25f, 7));
  });
}

// The library's, but it becomes vector code.
[[gnu::always_inline]] inline float length_of(float x, float y) {
  return static_cast<float>(std::sqrt(static_cast<double>(x) * x + static_cast<double>(y) * y));
}

// Measured in metres from the middle of the face.
void face(const Material& m, const Places& places, const Colors& out) {
  const std::size_t n = places.u.size();
  std::vector<float> blush(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float x = std::abs(places.u[i] - 0.75f * m.scale), y = places.v[i];
    const float power = -((x - 0.04f) * (x - 0.04f) + (y + 0.145f) * (y + 0.145f)) / 0.0006f;
    blush[i] = power > -30 ? 0.5f * std::exp(power) : 0.0f;  // less does not show in a float
  }
  const Vector3f skin = m.color, brows = m.accent, red = srgb(0xD98A70), white = srgb(0xF4F0EA),
                 iris_color = srgb(0x2A1B12), lips = srgb(0xA8504A);
  const float* __restrict cheeks = blush.data();
  const float* __restrict u = places.u.data();
  const float* __restrict v = places.v.data();
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

// The share of the darker colour in wood whose grain runs along u; coordinates in cells of the pattern.
inline float grain(float along, float across) {
  const float rings =
      value_noise(0.35f * along, 4 * across, 11) + 0.5f * value_noise(1.2f * along, 14 * across, 12);
  return between_0_and_1(rings - 0.35f);
}

// Each plank has its own tint and its own piece of wood.
void parquet(const Material& m, const Places& places, const Colors& out) {
  float* __restrict r = out.r.data();
  float* __restrict g = out.g.data();
  float* __restrict b = out.b.data();
  const float* __restrict u = places.u.data();
  const Vector3f one = m.color, other = m.accent;
  const float scale = m.scale;
  for_each_place(m, places, [&](std::size_t i, float, float y) {
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

Vector3f rug(const Material& m, const Vector2f& uv) {
  const float edge = std::min({uv.x(), 1 - uv.x(), uv.y(), 1 - uv.y()});
  static const Vector3f cream = srgb(0xE3D5B8);
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

// Of the patterns that are computed place by place.
Vector3f color_at(const Material& m, const Vector2f& uv) {
  const Vector2f p = uv / m.scale;
  switch (m.pattern) {
    case Pattern::kWallpaper: {
      const float stripe = step(0.5f, std::abs(fraction(p.x()) - 0.5f) * 2, 0.06f);
      const float diamond = std::abs(fraction(p.x() + 0.5f) - 0.5f) + 0.6f * std::abs(fraction(p.y()) - 0.5f);
      const Vector3f ground = mix_colors(m.color, m.accent, 0.35f * stripe);
      return mix_colors(ground, m.accent, 0.8f * (1 - step(0.12f, diamond, 0.04f))) *
             (1 + 0.05f * mottle(p.x() * 7, p.y() * 7, 6));
    }
    case Pattern::kRug:
      return rug(m, uv);
    case Pattern::kBook: {
      const float v = fraction(p.y());
      const bool band = (v > 0.10f && v < 0.15f) || (v > 0.84f && v < 0.88f);
      const bool title = v > 0.30f && v < 0.68f && unit(hash(cell(p.y() * 40), cell(p.x() * 9), 8)) > 0.55f;
      return band || title ? m.accent : m.color * (1 + 0.15f * mottle(p.x() * 6, p.y() * 6, 8));
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
    case Pattern::kStripes:
      return fraction(p.y()) < 0.5f ? m.color : m.accent;
    case Pattern::kPlain:
    case Pattern::kPlaster:
    case Pattern::kFabric:
    case Pattern::kPlaid:
    case Pattern::kHair:
    case Pattern::kFace:
    case Pattern::kWood:
    case Pattern::kParquet:
      break;  // computed many at a time
  }
  return m.color;
}

}  // namespace

void albedo(const Material& m, const Places& places, const Colors& out) {
  assert(places.v.size() == places.u.size() && out.r.size() == places.u.size() &&
         out.g.size() == places.u.size() && out.b.size() == places.u.size());
  switch (m.pattern) {
    case Pattern::kPlain:
      return tint(m, places, out, [](float x, float y) { return 1 + 0.12f * mottle(x, y, 1); });
    case Pattern::kPlaster:
      return tint(m, places, out, [](float x, float y) {
        return 1 + 0.10f * mottle(x, y, 2) + 0.06f * mottle(x * 9, y * 9, 4);
      });
    case Pattern::kHair:
      return tint(m, places, out,
                  [](float x, float y) { return 0.6f + 0.8f * value_noise(x, 0.15f * y, 10); });
    case Pattern::kFabric:
      return fabric(m, places, out);
    case Pattern::kWood:
      return blend(m, places, out,
                   [](std::size_t, float x, float y) { return std::pair(grain(x, y), 1.0f); });
    case Pattern::kParquet:
      return parquet(m, places, out);
    case Pattern::kPlaid:
      return plaid(m, places, out);
    case Pattern::kFace:
      return face(m, places, out);
    default:
      for (std::size_t i = 0; i < places.u.size(); ++i) {
        const Vector3f color = color_at(m, {places.u[i], places.v[i]});
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
