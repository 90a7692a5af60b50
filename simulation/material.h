#pragma once

// What surfaces look like and what they do to a Kinect's infrared dots. Patterns are procedural and live on a
// surface's own coordinates, so that every camera sees the same picture on the wall.
//
// Thread: free functions on values, safe anywhere.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "common/frame/image.h"

namespace copresence::simulation {

enum class Pattern : std::uint8_t {
  kPlain,      ///< slightly mottled
  kPlaster,    ///< a painted wall with grain
  kWallpaper,  ///< broad stripes with small diamonds
  kWood,       ///< grain along u
  kParquet,    ///< staggered planks along u
  kRug,        ///< borders and diamonds; uv from 0 to 1
  kFabric,     ///< a coarse weave
  kBook,       ///< bands as on a spine; v along the spine
  kPicture,    ///< hills, sun and sea; uv from 0 to 1
  kPoster,     ///< coloured circles and bars; uv from 0 to 1
  kOutdoors,   ///< trees below a sky; uv from 0 to 1
  kLeaf,       ///< a vein along v
  kPlaid,      ///< a checked shirt
  kStripes,    ///< across v
  kHair,       ///< strands along v
  kFace,       ///< eyes, brows and mouth where u is 3/4 of `scale`, v metres above the neck, upwards negative
};

/// Colours are linear light, 0 to 1.
struct Material {
  Pattern pattern = Pattern::kPlain;
  Eigen::Vector3f color{0.5f, 0.5f, 0.5f};
  Eigen::Vector3f accent{0.2f, 0.2f, 0.2f};
  float scale = 0.1f;     ///< size of the pattern's cell in units of uv, mostly metres
  float emission = 0;     ///< light given off, as a multiple of the pattern's colour
  float mirror = 0;       ///< share of light reflected as by a mirror
  float infrared = 0.6f;  ///< share of the projector's light that comes back diffusely
};

/// 0xRRGGBB as screens take it, in linear light.
Eigen::Vector3f srgb(std::uint32_t hex);

/// Places on a surface, and colours or light, coordinate by coordinate so that many are computed at once.
struct Places {
  std::span<const float> u, v;
};
struct Colors {
  std::span<float> r, g, b;
};

/// What a screen needs to show this light: the sRGB curve with a soft shoulder above 0.8.
Rgb8 to_screen(const Eigen::Vector3f& light);

/// The same for many: `screen` says how many. Requires as many lights or more.
void to_screen(const Colors& light, std::span<Rgb8> screen);

/// The pattern's colour at a place on the surface.
Eigen::Vector3f albedo(const Material& material, const Eigen::Vector2f& uv);

/// The same for many places. Requires spans of one length that do not overlap.
void albedo(const Material& material, const Places& places, const Colors& colors);

}  // namespace copresence::simulation
