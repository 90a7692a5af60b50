#include "simulation/figure_hits.h"

#include <algorithm>

namespace copresence::simulation {

FigureHits::FigureHits(std::size_t picture_width, std::size_t picture_height, std::size_t part_count)
    : width(picture_width), height(picture_height), parts(part_count), part_of(width * height, -1) {}

void FigureHits::clear() {
  for (const Run& run : runs)
    std::fill_n(part_of.begin() + static_cast<std::ptrdiff_t>(run.first), run.count, std::int8_t{-1});
  for (std::vector<Hit>& part : parts) part.clear();
  runs.clear();
  outline.clear();
  looks.clear();
}

void FigureHits::close() {
  std::vector<std::size_t> first(height, width), last(height, 0);  // per row
  for (std::size_t part = 0; part < parts.size(); ++part) {
    for (const Hit& hit : parts[part]) {
      part_of[hit.pixel] = static_cast<std::int8_t>(part);
      const std::size_t y = hit.pixel / width, x = hit.pixel % width;
      first[y] = std::min(first[y], x);
      last[y] = std::max(last[y], x);
    }
  }
  std::vector<std::uint8_t> differs(width);
  for (std::size_t y = 0; y < height; ++y) {
    // What is beside it, too.
    const std::size_t above = y - (y > 0), below = y + (y + 1 < height);
    std::size_t left = std::min({first[above], first[y], first[below]}),
                right = std::max({last[above], last[y], last[below]});
    if (left > right) continue;
    left -= left > 0;
    right += right + 1 < width;
    runs.push_back({y * width + left, right + 1 - left});
    if (y == 0 || y + 1 == height) continue;
    const std::int8_t* __restrict row = part_of.data() + y * width;
    std::uint8_t* __restrict found = differs.data();
    const std::size_t begin = std::max<std::size_t>(left, 1), end = std::min(right + 1, width - 1);
    for (std::size_t x = begin; x < end; ++x) {
      found[x] = static_cast<std::uint8_t>((row[x] ^ row[x - 1]) | (row[x] ^ row[x + 1]) |
                                           (row[x] ^ *(row + x - width)) | (row[x] ^ row[x + width]));
    }
    for (std::size_t x = begin; x < end; ++x) {
      if (found[x]) outline.push_back(static_cast<std::uint32_t>(y * width + x));
    }
  }
}

}  // namespace copresence::simulation
