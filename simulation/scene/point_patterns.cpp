#include "simulation/scene/point_patterns.h"

#include <array>

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

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
  if (x < 0.06f || x > 0.94f || y < 0.08f || y > 0.92f) return srgb(0xEFE9DC);  // The mount.
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

}  // namespace

Vector3f color_at_point(const Material& m, const Vector2f& uv) {
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
      break;  // albedo() evaluates these patterns in batches.
  }
  return m.color;
}

}  // namespace copresence::simulation
