#include "render_client/display/stereo.h"

#include <algorithm>
#include <cassert>

namespace copresence::display {
namespace {

void copy_row(const Image<Rgba8>& from, int from_row, Image<Rgba8>& to, int column, int row) {
  const auto pixels = from.row(from_row);
  std::copy(pixels.begin(), pixels.end(), to.row(row).begin() + column);
}

/// Columns or rows of a half of the display lie in the middle of two of the display.
constexpr viewpoint::PixelGrid kHalfWidth{.column_step = 2, .first_column = 0.5};
constexpr viewpoint::PixelGrid kHalfHeight{.row_step = 2, .first_row = 0.5};

std::array<viewpoint::PixelGrid, 2> grids(StereoMode mode) {
  switch (mode) {
    case StereoMode::kSide:
      return {kHalfWidth, kHalfWidth};
    case StereoMode::kTop:
      return {kHalfHeight, kHalfHeight};
    case StereoMode::kRows:
      return {viewpoint::PixelGrid{.row_step = 2, .first_row = 0},
              viewpoint::PixelGrid{.row_step = 2, .first_row = 1}};
    case StereoMode::kNone:
    case StereoMode::kAnaglyph:
      break;
  }
  return {};
}

}  // namespace

const char* name_of(StereoMode mode) {
  constexpr std::array kNames = {"none", "side", "top", "anaglyph", "rows"};
  return kNames[static_cast<std::size_t>(mode)];
}

std::optional<StereoMode> parse_stereo(std::string_view name) {
  for (const StereoMode mode : kStereoModes) {
    if (name == name_of(mode)) return mode;
  }
  return std::nullopt;
}

StereoMode next(StereoMode mode) {
  return kStereoModes[(static_cast<std::size_t>(mode) + 1) % kStereoModes.size()];
}

std::vector<viewpoint::Eye> eyes_of(const Stereo& stereo) {
  if (stereo.mode == StereoMode::kNone) return std::vector<viewpoint::Eye>(1);
  std::vector<viewpoint::Eye> eyes(2);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    eyes[i].head_from_eye.translation.x() = (i == 0 ? -0.5 : 0.5) * stereo.eye_distance_m;
    eyes[i].screen_distance_m = stereo.screen_distance_m;
    eyes[i].pixels = grids(stereo.mode)[i];
  }
  return eyes;
}

void compose(StereoMode mode, const Image<Rgba8>& left, const Image<Rgba8>& right, Image<Rgba8>& display) {
  assert(mode != StereoMode::kNone && same_shape(left, right));
  const int width = left.width(), height = left.height();
  const bool is_twice_as_wide = mode == StereoMode::kSide;
  const bool is_twice_as_high = mode == StereoMode::kTop || mode == StereoMode::kRows;
  display.resize(is_twice_as_wide ? 2 * width : width, is_twice_as_high ? 2 * height : height);
  for (int y = 0; y < height; ++y) {
    switch (mode) {
      case StereoMode::kSide:
        copy_row(left, y, display, 0, y);
        copy_row(right, y, display, width, y);
        break;
      case StereoMode::kTop:
        copy_row(left, y, display, 0, y);
        copy_row(right, y, display, 0, height + y);
        break;
      case StereoMode::kRows:
        copy_row(left, y, display, 0, 2 * y);
        copy_row(right, y, display, 0, 2 * y + 1);
        break;
      case StereoMode::kAnaglyph:
        for (int x = 0; x < width; ++x) {
          const Rgba8 red = left(x, y), cyan = right(x, y);
          display(x, y) = {red.r, cyan.g, cyan.b, std::max(red.a, cyan.a)};
        }
        break;
      case StereoMode::kNone:
        break;
    }
  }
}

}  // namespace copresence::display
