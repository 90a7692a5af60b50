#pragma once

// The appearance of surfaces, in colour and in the infrared light of a Kinect's projector. Patterns
// are functions of the texture coordinates, so every camera sees the same pattern on a surface.
// Thread: free functions on values, safe anywhere.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "common/frame/image.h"

namespace copresence::simulation {

enum class Pattern : std::uint8_t {
  kPlain,      ///< One colour with faint patches.
  kPlaster,    ///< Painted wall with grain.
  kWallpaper,  ///< Broad stripes with small diamonds.
  kWood,       ///< Grain along u.
  kParquet,    ///< Staggered planks along u.
  kRug,        ///< Borders and diamonds; uv from 0 to 1.
  kFabric,     ///< Coarse weave.
  kBook,       ///< Bands and a title; v along the spine.
  kPicture,    ///< Hills, sun and sea; uv from 0 to 1.
  kPoster,     ///< Coloured circles and bars; uv from 0 to 1.
  kOutdoors,   ///< Trees below a sky; uv from 0 to 1.
  kLeaf,       ///< A vein along v.
  kPlaid,      ///< Checked cloth.
  kStripes,    ///< Stripes across v.
  kHair,       ///< Strands along v.
  /// Eyes, brows and mouth around u = 0.75 * scale. The coordinate v is in metres from the neck,
  /// negative upwards.
  kFace,
};

/// Colours are linear, 0 to 1 per channel.
struct Material {
  Pattern pattern = Pattern::kPlain;
  Eigen::Vector3f color{0.5f, 0.5f, 0.5f};
  Eigen::Vector3f accent{0.2f, 0.2f, 0.2f};
  float scale = 0.1f;     ///< Size of a cell of the pattern in texture coordinates, mostly metres.
  float emission = 0;     ///< Emitted light as a multiple of the pattern's colour.
  float mirror = 0;       ///< Share of light that is reflected specularly.
  float infrared = 0.6f;  ///< Share of the projector's light that is reflected diffusely.
};

/// Converts an sRGB colour 0xRRGGBB to linear light.
Eigen::Vector3f srgb(std::uint32_t hex);

/// Texture coordinates of many points. Separate arrays per coordinate let loops become vector code.
struct SurfacePoints {
  std::span<const float> u, v;
};
/// Colours or light of many points, in one array per channel.
struct Colors {
  std::span<float> r, g, b;
};

/// Maps linear light to an sRGB pixel. Light above 0.8 is compressed smoothly.
Rgb8 to_screen(const Eigen::Vector3f& light);

/// Maps many points. `screen` sets their number. Requires at least as many lights as pixels.
void to_screen(const Colors& light, std::span<Rgb8> screen);

/// Returns the colour of the pattern at texture coordinates `uv`.
Eigen::Vector3f albedo(const Material& material, const Eigen::Vector2f& uv);

/// Computes the colours of many points. Each point gets exactly the colour that the other albedo()
/// returns. Requires spans of equal length that do not overlap.
void albedo(const Material& material, const SurfacePoints& points, const Colors& colors);

}  // namespace copresence::simulation
