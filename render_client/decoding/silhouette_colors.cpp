#include "render_client/decoding/silhouette_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace copresence::decoding {
namespace {

constexpr int kReach = SilhouetteColors::kReach;
constexpr int kWidestGap = SilhouetteColors::kWidestGap;
constexpr int kReferencePixels = 3;  // Number of pixels that give a surface's mean colour.

/// A colour is foreign if its squared distance from its own surface's colour is this many times the
/// squared distance from the other surface's colour.
constexpr float kForeign = 4;

struct Color {
  float r = 0, g = 0, b = 0;
};

Color color_of(const Rgb8& pixel) {
  return {float(pixel.r), float(pixel.g), float(pixel.b)};
}

std::uint8_t rounded(float value) {
  return static_cast<std::uint8_t>(value + 0.5F);
}

float squared_distance(const Color& a, const Color& b) {
  const float r = a.r - b.r, g = a.g - b.g, blue = a.b - b.b;
  return r * r + g * g + blue * blue;
}

void invert_row(const std::uint16_t* from, int width, float* to) {
  for (int x = 0; x < width; ++x) {
    const auto value = static_cast<float>(from[x]);
    to[x] = std::min(value, 1.0F) / std::max(value, 1.0F);  // Is 0 for a hole.
  }
}

// Sets out[i] to 1 where a[i] and b[i] differ by more than `edge`. One of them may be a hole.
void compare_rows(const float* a, const float* b, int count, float edge, std::uint8_t* out) {
  for (int i = 0; i < count; ++i) out[i] = static_cast<std::uint8_t>(std::abs(a[i] - b[i]) > edge);
}

}  // namespace

void SilhouetteColors::apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise) {
  if (!frame.color) return;
  edge_ = kEdgeSteps * static_cast<float>(noise.inverse_step() * metres_per_unit(unit));
  const int width = frame.depth.width(), height = frame.depth.height();
  above_.resize(static_cast<std::size_t>(width));
  here_.resize(static_cast<std::size_t>(width));
  edges_.assign(static_cast<std::size_t>(width) + sizeof(std::uint64_t), 0);
  for (int y = 0; y < height; ++y) {
    here_.swap(above_);
    invert_row(frame.depth.row(y).data(), width, here_.data());
    edges_[static_cast<std::size_t>(width) - 1] = 0;  // The last pixel has no right neighbour.
    compare_rows(here_.data(), here_.data() + 1, width - 1, edge_, edges_.data());
    separate_row(frame, y, true);
    if (y == 0) continue;
    compare_rows(above_.data(), here_.data(), width, edge_, edges_.data());
    separate_row(frame, y - 1, false);
  }
}

// Separates the colours at the row's edges: those between the pixels of row y and their right
// neighbours, or those between the rows y and y + 1.
void SilhouetteColors::separate_row(RgbdFrame& frame, int y, bool across) const {
  const int width = frame.depth.width(), height = frame.depth.height();
  for (int x = 0; x < width; x += static_cast<int>(sizeof(std::uint64_t))) {
    std::uint64_t any;
    std::memcpy(&any, edges_.data() + x, sizeof any);
    if (any == 0) continue;
    for (int i = x; i < std::min(x + static_cast<int>(sizeof any), width); ++i) {
      if (edges_[i] == 0) continue;
      const auto columns = static_cast<std::ptrdiff_t>(width);
      if (across) {
        separate(frame, {y * columns, 1, width}, i);
      } else {
        separate(frame, {i, columns, height}, y);
      }
    }
  }
}

// Separates the colours at the edge between pixels `at` and at + 1 of a line.
void SilhouetteColors::separate(RgbdFrame& frame, Line line, int at) const {
  const std::uint16_t* const depth = frame.depth.data();
  Rgb8* const colors = frame.color->data();
  const bool is_reversed = depth[line.index(at)] == 0;
  if (is_reversed) {
    // The line is reversed, so that it begins with a surface.
    line = {line.index(line.length - 1), -line.step, line.length};
    at = line.length - 2 - at;
  }
  const auto depth_at = [&](int i) { return depth[line.index(i)]; };
  const auto color_at = [&](int i) -> Rgb8& { return colors[line.index(i)]; };
  const std::uint16_t one = depth_at(at);
  if (one == 0) return;
  int next = at + 1;
  while (next < line.length && next - at <= kWidestGap && depth_at(next) == 0) ++next;
  if (next == line.length) return;
  const std::uint16_t other = depth_at(next);
  if (is_reversed && other != 0) return;  // The gap has been examined from its other end.
  if (other == 0) next = at + 1;          // The pixels of a wide gap are the other surface.
  const auto is_on = [&](std::uint16_t surface, int i) {
    if (i < 0 || i >= line.length) return false;
    if (surface == 0 || depth_at(i) == 0) return surface == depth_at(i);
    return std::abs(1.0F / float(depth_at(i)) - 1.0F / float(surface)) <= edge_;
  };
  if (is_on(one, next)) return;

  // Computes the mean colour of the surface's pixels that are at least kReach away from the edge.
  const auto reference = [&](std::uint16_t surface, int from, int direction, Color& mean) {
    int count = 0;
    for (int k = 0; k < kReferencePixels; ++k) {
      const int i = from + direction * (kReach + k);
      if (!is_on(surface, i)) break;
      const Color color = color_of(color_at(i));
      mean = {mean.r + color.r, mean.g + color.g, mean.b + color.b};
      ++count;
    }
    if (count == 0) return false;
    mean = {mean.r / float(count), mean.g / float(count), mean.b / float(count)};
    return true;
  };
  Color first_color, second_color;
  if (!reference(one, at, -1, first_color) || !reference(other, next, 1, second_color)) return;
  const float contrast = squared_distance(first_color, second_color);
  if (contrast < kLeastContrast * kLeastContrast) return;

  // Corrects the pixels of the farther surface and the holes in the gap.
  const bool first_is_nearer = other == 0 || one < other;
  const Color& own = first_is_nearer ? second_color : first_color;
  const Color& foreign = first_is_nearer ? first_color : second_color;
  const int begin = first_is_nearer ? at + 1 : at - kReach + 1;
  const int end = first_is_nearer ? next + kReach : next;
  const Rgb8 pure{rounded(own.r), rounded(own.g), rounded(own.b)};
  for (int i = begin; i < end; ++i) {
    const Color color = color_of(color_at(i));
    if (squared_distance(color, own) > kForeign * squared_distance(color, foreign)) color_at(i) = pure;
  }
}

}  // namespace copresence::decoding
