#pragma once

// Draws a frame number into a colour picture as a row of light and dark cells in the top left
// corner. The cells survive video coding, so a viewer knows the capture instant.
// Thread: free functions on values, safe anywhere.

#include <cstdint>
#include <optional>
#include <span>

#include "common/frame/image.h"

namespace copresence::simulation {

/// Draws 36 cells of 16x16 pixels: a light cell, a dark cell, 32 cells for the bits of the number,
/// and two for a checksum. The highest bit comes first, and a light cell is 1. The checksum is the
/// number of ones, modulo 4. Requires a picture of at least 576x16 pixels, stored row by row.
void draw_marker(std::uint32_t number, std::span<Rgb8> picture, int width);

/// Reads the number. Returns nothing if the fixed cells or the checksum are wrong.
std::optional<std::uint32_t> read_marker(const ColorImage& picture);

}  // namespace copresence::simulation
