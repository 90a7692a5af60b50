#include "render_client/display/view_colors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace copresence::display {
namespace {

using renderer::MergedView;
using renderer::Origin;

/// Colours that remain distinct with red-green blindness (Okabe and Ito).
constexpr std::array kLayers = {Rgb8{230, 159, 0},   Rgb8{86, 180, 233}, Rgb8{0, 158, 115},
                                Rgb8{240, 228, 66},  Rgb8{0, 114, 178},  Rgb8{213, 94, 0},
                                Rgb8{204, 121, 167}, Rgb8{160, 160, 160}};
constexpr std::array kHeat = {Rgb8{48, 18, 130}, Rgb8{40, 130, 220}, Rgb8{60, 200, 90}, Rgb8{250, 220, 50},
                              Rgb8{220, 40, 20}};
constexpr int kRememberedPercent = 50;
constexpr int kLeastPercent = 35;  // Brightness of a layer's colour where the view is black.

int luma(Rgba8 pixel) {
  return (299 * pixel.r + 587 * pixel.g + 114 * pixel.b) / 1000;
}

Rgba8 at_brightness(Rgb8 color, int percent, std::uint8_t alpha) {
  const auto scaled = [percent](int channel) { return static_cast<std::uint8_t>(channel * percent / 100); };
  return {scaled(color.r), scaled(color.g), scaled(color.b), alpha};
}

Rgba8 color_of(ViewColors colors, std::span<const std::size_t> cameras, const MergedView& view, int x,
               int y) {
  const Rgba8 pixel = view.color(x, y);
  const Origin origin = view.origin(x, y);
  if (origin != Origin::kSeen && origin != Origin::kRemembered) {
    const auto gray = static_cast<std::uint8_t>(colors == ViewColors::kLayers ? luma(pixel) / 2 : 0);
    return {gray, gray, gray, pixel.a};
  }
  const int percent = origin == Origin::kRemembered ? kRememberedPercent : 100;
  if (colors == ViewColors::kQuality)
    return at_brightness(quality_color(view.quality(x, y)), percent, pixel.a);
  const int brightness = kLeastPercent + (100 - kLeastPercent) * luma(pixel) / 255;
  return at_brightness(layer_color(cameras[view.camera(x, y)]), percent * brightness / 100, pixel.a);
}

}  // namespace

Rgb8 layer_color(std::size_t camera) {
  return kLayers[camera % kLayers.size()];
}

Rgb8 quality_color(float quality) {
  const float decades = std::log(kBestQuality / kLeastQuality);
  const float share =
      quality > 0 ? std::clamp(std::log(quality / kLeastQuality) / decades, 0.0F, 1.0F) : 0.0F;
  const float position = share * static_cast<float>(kHeat.size() - 1);
  const auto index = std::min(static_cast<std::size_t>(position), kHeat.size() - 2);
  const float part = position - static_cast<float>(index);
  const auto mix = [part](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(
        std::lround(static_cast<float>(from) + part * static_cast<float>(to - from)));
  };
  const Rgb8 from = kHeat[index], to = kHeat[index + 1];
  return {mix(from.r, to.r), mix(from.g, to.g), mix(from.b, to.b)};
}

void recolor(ViewColors colors, std::span<const std::size_t> cameras, MergedView& view) {
  if (colors == ViewColors::kCameras) return;
  assert(same_shape(view.color, view.origin) && same_shape(view.color, view.camera));
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) view.color(x, y) = color_of(colors, cameras, view, x, y);
  }
  view.texture = 0;
}

}  // namespace copresence::display
