#pragma once

// A frame's number drawn into its colour picture as a row of light and dark cells in the top left corner, so that it
// survives video coding and whoever looks at a view can tell which instant it shows.
//
// Thread: free functions on values, safe anywhere.

#include <cstdint>
#include <optional>
#include <span>

#include "common/frame/image.h"

namespace copresence::simulation {

/// 36 cells of 16x16 pixels: light, dark, 32 bits from the highest on (light is 1), two bits that count the light ones.
/// Requires a picture, row by row, of at least 576x16.
void draw_marker(std::uint32_t number, std::span<Rgb8> picture, int width);

/// The number, if there is a marker: nothing where the cells do not add up.
std::optional<std::uint32_t> read_marker(const ColorImage& picture);

}  // namespace copresence::simulation
