#include "render_client/renderer/source_texture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

constexpr int kTiltLevel = 2;  // of FlatBlocks
static_assert(kBlockSizes[kTiltLevel] == kCell);

// Least squares over the pixels of a cell that have depth; w = 0 where they are too few or in one line.
Plane fit_cell(const InverseDepth& inverse, int x_begin, int y_begin) {
  const int y_end = std::min(y_begin + kCell, inverse.height);
  constexpr float kMiddle = 0.5F * kCell;  // where a block of kCell pixels has its plane, too
  static_assert(kCell == kLanes);
  // Moments by column first. The image is padded: columns beyond it are there, but do not count.
  const Ints in_image = ramp() < static_cast<float>(inverse.width - x_begin);
  Floats columns_n{}, columns_y{}, columns_yy{}, columns_w{}, columns_yw{};
  for (int v = y_begin; v < y_end; ++v) {
    const Floats here = load<Floats>(&inverse.w(x_begin, v));
    const Floats value = in_image ? here : Floats{};
    const Floats there = value > 0 ? all(1.0F) : Floats{};
    const float dv = static_cast<float>(v - y_begin) - kMiddle;
    columns_n += there;
    columns_y += there * dv;
    columns_yy += there * (dv * dv);
    columns_w += value;
    columns_yw += value * dv;
  }
  const Floats du = ramp() - kMiddle;
  const float n = sum(columns_n), x = sum(columns_n * du), y = sum(columns_y);
  const float xx = sum(columns_n * du * du), xy = sum(columns_y * du), yy = sum(columns_yy);
  const float w = sum(columns_w), xw = sum(columns_w * du), yw = sum(columns_yw);
  if (n < kCellPixels) return {};
  const float sxx = xx - x * x / n, sxy = xy - x * y / n, syy = yy - y * y / n;
  const float sxw = xw - x * w / n, syw = yw - y * w / n;
  const float determinant = sxx * syy - sxy * sxy;
  if (determinant < 1) return {};
  Plane plane;
  plane.dx = (sxw * syy - syw * sxy) / determinant;
  plane.dy = (syw * sxx - sxw * sxy) / determinant;
  plane.w = (w - x * plane.dx - y * plane.dy) / n;
  return plane;
}

// One row of the tilts' image, between the cells' centres in both directions.
void interpolate_row(const Image<float>& cosines, int y, std::vector<float>& between_rows,
                     std::vector<float>& row) {
  const float at = (static_cast<float>(y) + 0.5F) / kCell - 0.5F;
  const int upper = std::clamp(static_cast<int>(std::floor(at)), 0, cosines.height() - 1);
  const int lower = std::min(upper + 1, cosines.height() - 1);
  const float t = std::clamp(at - static_cast<float>(upper), 0.0F, 1.0F);
  const int cells = cosines.width();
  // Both ends are repeated, so that every pixel lies between two numbers.
  between_rows.resize(cells + 2);
  for (int i = 0; i < cells; ++i) {
    between_rows[i + 1] = cosines(i, upper) + (cosines(i, lower) - cosines(i, upper)) * t;
  }
  between_rows[0] = between_rows[1];
  between_rows[cells + 1] = between_rows[cells];
  row.resize(static_cast<std::size_t>(cells + 1) * kCell);
  for (int i = 0; i <= cells; ++i) {
    const float begin = between_rows[i], change = between_rows[i + 1] - begin;
    for (int k = 0; k < kCell; ++k) {
      row[static_cast<std::size_t>(i) * kCell + k] =
          begin + change * ((static_cast<float>(k) + 0.5F) * (1.0F / kCell));
    }
  }
}

std::uint32_t pack(std::uint32_t r, std::uint32_t g, std::uint32_t b) {
  return r | g << 8 | b << 16;
}

// Eight pixels at a time; `row` has whole groups of kLanes, of which the last may be padding.
void match_row(const Eigen::Matrix<float, 3, 4>& m, std::span<std::uint32_t> row) {
  const auto channel = [&](int c, const Floats& r, const Floats& g, const Floats& b) {
    const Floats value = m(c, 0) * r + m(c, 1) * g + m(c, 2) * b + 255 * m(c, 3);
    return truncated(smaller(larger(value, Floats{}), all(255.0F)) + 0.5F);
  };
  for (std::size_t x = 0; x < row.size(); x += kLanes) {
    const Ints texels = load<Ints>(&row[x]);
    const Floats r = as_floats(texels & 0xFF), g = as_floats(texels >> 8 & 0xFF),
                 b = as_floats(texels >> 16 & 0xFF);
    store(&row[x], channel(0, r, g, b) | channel(1, r, g, b) << 8 | channel(2, r, g, b) << 16);
  }
}

}  // namespace

void measure_tilts(const InverseDepth& inverse, const FlatBlocks& blocks, const CameraModel& camera,
                   Image<float>& cosines) {
  cosines.resize((inverse.width + kCell - 1) / kCell, (inverse.height + kCell - 1) / kCell);
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const Image<Plane>& flat = blocks.planes[kTiltLevel];
  for (int j = 0; j < cosines.height(); ++j) {
    for (int i = 0; i < cosines.width(); ++i) {
      const bool has_block = i < flat.width() && j < flat.height();
      const Plane plane =
          has_block && flat(i, j).is_flat() ? flat(i, j) : fit_cell(inverse, i * kCell, j * kCell);
      // A lens's distortion tilts a cell's ray by far less than noise tilts its plane.
      const float x = (static_cast<float>(i * kCell + kCell / 2) - cx) / fx;
      const float y = (static_cast<float>(j * kCell + kCell / 2) - cy) / fy;
      cosines(i, j) =
          plane.is_flat() ? cos_theta(plane.w, plane.dx * fx, plane.dy * fy, x, y) : kUnknownCosine;
    }
  }
}

void make_texture(const RgbdFrame& frame, const Image<float>& cosines,
                  const Eigen::Matrix<float, 3, 4>& color_matching, Texture& texture) {
  const int width = frame.depth.width(), height = frame.depth.height();
  texture.resize(width + 1, height + 1);
  const bool matched = color_matching != Eigen::Matrix<float, 3, 4>::Identity();
  std::vector<float> between_rows, tilt;
  std::vector<std::uint32_t> packed((width + kLanes - 1) / kLanes * kLanes);
  for (int y = 0; y < height; ++y) {
    const auto to = texture.row(y);
    interpolate_row(cosines, y, between_rows, tilt);
    // The first pixel lies half a cell after the repeated end.
    const float* const cosine = tilt.data() + kCell / 2;
    if (!frame.color) {
      for (int x = 0; x < width; ++x) {
        to[x] = static_cast<std::uint32_t>(
                    static_cast<std::int32_t>(255 * shade_without_color(cosine[x]) + 0.5F)) *
                0x10101U;
      }
    } else {
      const auto from = frame.color->row(y);
      for (int x = 0; x < width; ++x) packed[x] = pack(from[x].r, from[x].g, from[x].b);
      if (matched) match_row(color_matching, packed);
      std::copy_n(packed.begin(), width, to.begin());
    }
    const auto state = frame.state.row(y);
    for (int x = 0; x < width; ++x) {
      const float worth = cosine[x] * (state[x] == DepthState::kFilled ? 255 * kFilledWorth : 255.0F);
      const std::int32_t alpha = std::max(1, static_cast<std::int32_t>(worth + 0.5F));
      to[x] |= static_cast<std::uint32_t>(alpha) << 24;
    }
    to[width] = to[width - 1];
  }
  const auto last = texture.row(height - 1);
  std::copy(last.begin(), last.end(), texture.row(height).begin());
}

}  // namespace copresence::renderer
