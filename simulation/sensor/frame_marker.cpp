#include "simulation/sensor/frame_marker.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace copresence::simulation {
namespace {

constexpr int kCell = 16, kBits = 36;

std::uint64_t with_checks(std::uint32_t number) {
  const auto ones = static_cast<std::uint64_t>(std::popcount(number)) & 3;
  return std::uint64_t{2} << 34 | std::uint64_t{number} << 2 | ones;
}

}  // namespace

void draw_marker(std::uint32_t number, std::span<Rgb8> picture, int width) {
  assert(width >= kCell * kBits && picture.size() >= static_cast<std::size_t>(kCell) * width);
  const std::uint64_t bits = with_checks(number);
  for (int y = 0; y < kCell; ++y) {
    const auto row = picture.subspan(static_cast<std::size_t>(y) * width);
    for (int bit = 0; bit < kBits; ++bit) {
      const std::uint8_t shade = bits >> (kBits - 1 - bit) & 1 ? 235 : 16;
      std::fill_n(row.begin() + bit * kCell, kCell, Rgb8{shade, shade, shade});
    }
  }
}

std::optional<std::uint32_t> read_marker(const ColorImage& picture) {
  if (picture.width() < kCell * kBits || picture.height() < kCell) return std::nullopt;
  std::uint64_t bits = 0;
  for (int bit = 0; bit < kBits; ++bit) {
    int sum = 0;  // Sum over the inner quarter of the cell.
    for (int y = kCell / 4; y < 3 * kCell / 4; ++y) {
      for (int x = kCell / 4; x < 3 * kCell / 4; ++x)
        sum += picture.row(y)[static_cast<std::size_t>(bit * kCell + x)].g;
    }
    bits = bits << 1 | (sum > 128 * kCell * kCell / 4 ? 1u : 0u);
  }
  const auto number = static_cast<std::uint32_t>(bits >> 2);
  return with_checks(number) == bits ? std::optional(number) : std::nullopt;
}

}  // namespace copresence::simulation
