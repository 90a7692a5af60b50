#include "render_client/renderer/cpu/camera_texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

constexpr int kCellLevel = 2;
static_assert(kBlockSizes[kCellLevel] == kCell);

// Fits a plane to the pixels of a cell that have depth, by least squares. Returns w = 0 if these
// are too few or lie on one line.
Plane fit_cell(const InverseDepth& inverse, int x_begin, int y_begin) {
  const int y_end = std::min(y_begin + kCell, inverse.height);
  constexpr float kMiddle = 0.5F * kCell;  // The reference point of a plane, as in PlanarBlocks.
  static_assert(kCell == kLanes);
  // The moments of each column are summed first. Columns of the padding do not count.
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

// Interpolates the incidences of one row of pixels between the centres of the cells.
void interpolate_row(const Image<float>& incidences, int y, std::vector<float>& between_rows,
                     std::vector<float>& row) {
  const float at = (static_cast<float>(y) + 0.5F) / kCell - 0.5F;
  const int upper = std::clamp(static_cast<int>(std::floor(at)), 0, incidences.height() - 1);
  const int lower = std::min(upper + 1, incidences.height() - 1);
  const float t = std::clamp(at - static_cast<float>(upper), 0.0F, 1.0F);
  const int cells = incidences.width();
  // The first and the last value are repeated, so that every pixel lies between two values.
  between_rows.resize(cells + 2);
  const float* const above = incidences.row(upper).data();
  const float* const below = incidences.row(lower).data();
  for (int i = 0; i < cells; ++i) between_rows[i + 1] = above[i] + (below[i] - above[i]) * t;
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

using Bytes = std::uint8_t __attribute__((vector_size(16)));
using Half = std::int32_t __attribute__((vector_size(16)));

Bytes load_bytes(const void* from) {
  Bytes bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return bytes;
}

Ints join(const Bytes& first, const Bytes& second) {
  return __builtin_shufflevector(reinterpret_cast<Half>(first), reinterpret_cast<Half>(second), 0, 1, 2, 3, 4,
                                 5, 6, 7);
}

// Converts eight pixels of three bytes. Reads 28 bytes.
Ints unpack(const Rgb8* from) {
  static_assert(sizeof(Rgb8) == 3);
  const auto four = [](const Bytes& bytes) {
    return __builtin_shufflevector(bytes, Bytes{}, 0, 1, 2, 16, 3, 4, 5, 16, 6, 7, 8, 16, 9, 10, 11, 16);
  };
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(from);
  return join(four(load_bytes(bytes)), four(load_bytes(bytes + 12)));
}

// Converts eight depths. Reads 16 bytes.
Ints unpack(const std::uint16_t* from) {
  using Shorts = std::uint16_t __attribute__((vector_size(16)));
  return __builtin_convertvector(reinterpret_cast<Shorts>(load_bytes(from)), Ints);
}

// Converts eight states. Reads 16 bytes. The compiler's own conversion would not use vectors.
Ints unpack(const DepthState* from) {
  static_assert(sizeof(DepthState) == 1);
  const Bytes bytes = load_bytes(from);
  return join(
      __builtin_shufflevector(bytes, Bytes{}, 0, 16, 16, 16, 1, 16, 16, 16, 2, 16, 16, 16, 3, 16, 16, 16),
      __builtin_shufflevector(bytes, Bytes{}, 4, 16, 16, 16, 5, 16, 16, 16, 6, 16, 16, 16, 7, 16, 16, 16));
}

// Applies a camera's color_correction to values from 0 to 255.
class ColorCorrector {
 public:
  explicit ColorCorrector(const Eigen::Matrix<float, 3, 4>& matrix)
      : is_identity_(matrix == Eigen::Matrix<float, 3, 4>::Identity()) {
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 4; ++k) factors_[c][k] = all(k < 3 ? matrix(c, k) : 255 * matrix(c, k));
    }
  }

  Ints operator()(const Ints& texels) const {
    if (is_identity_) return texels;
    const Floats r = as_floats(texels & 0xFF), g = as_floats(texels >> 8 & 0xFF),
                 b = as_floats(texels >> 16 & 0xFF);
    const auto channel = [&](const std::array<Floats, 4>& f) {
      const Floats value = f[0] * r + f[1] * g + f[2] * b + f[3];
      return truncated(smaller(larger(value, Floats{}), all(255.0F)) + 0.5F);
    };
    return channel(factors_[0]) | channel(factors_[1]) << 8 | channel(factors_[2]) << 16;
  }

 private:
  bool is_identity_;
  std::array<std::array<Floats, 4>, 3> factors_;
};

Ints shade(const Floats& incidences) {
  const auto gray = [](float incidence) { return 255 * shade_without_color(incidence) + 0.5F; };
  Floats shades;
  for (int lane = 0; lane < kLanes; ++lane) shades[lane] = gray(incidences[lane]);
  return truncated(shades) * 0x10101;
}

// Factors of the weight for the pixels of a row, towards the left and right border (border_fade()).
std::vector<float> fades_across(int width) {
  std::vector<float> fades(static_cast<std::size_t>(width) + kLanes);
  for (int x = 0; x < width; ++x) fades[x] = border_fade(std::min(x, width - 1 - x), width);
  return fades;
}

Ints weight(const Floats& incidences, const Ints& states, const Ints& depths) {
  const Ints is_filled = states == static_cast<std::int32_t>(DepthState::kFilled);
  const Ints alpha = truncated(incidences * (is_filled ? all(255 * kFilledWeight) : all(255.0F)) + 0.5F);
  const Ints is_left_out = (depths == 0) & (states != static_cast<std::int32_t>(DepthState::kHole));
  return (larger(alpha, all(1)) & ~is_left_out) << 24;
}

// One row of a frame and of its texture. The last group of kLanes pixels may reach into the next
// rows, which are written later. So only the last rows of an image need a copy with spare room.
class Row {
 public:
  Row(const RgbdFrame& frame, CameraTexture& texture)
      : frame_(frame), texture_(texture), width_(frame.depth.width()) {}

  void begin(int y) {
    y_ = y;
    is_copy_ = (frame_.depth.height() - y) * width_ < width_ + kRoom;
    depths = is_copy_ ? copy_of_row(frame_.depth, depths_) : frame_.depth.row(y).data();
    states = is_copy_ ? copy_of_row(frame_.state, states_) : frame_.state.row(y).data();
    if (frame_.color) colors = is_copy_ ? copy_of_row(*frame_.color, colors_) : frame_.color->row(y).data();
    texels = is_copy_ ? copy_of_row(texture_, texels_) : texture_.row(y).data();
  }

  void end() {
    const auto to = texture_.row(y_);
    if (is_copy_) std::copy_n(texels_.begin(), width_, to.begin());
    to[width_] = to[width_ - 1];
  }

  const std::uint16_t* depths = nullptr;
  const DepthState* states = nullptr;
  const Rgb8* colors = nullptr;  // Null if the frame has no colour.
  std::uint32_t* texels = nullptr;

 private:
  static constexpr int kRoom = 2 * kLanes;

  template <class Pixel>
  Pixel* copy_of_row(const Image<Pixel>& image, std::vector<Pixel>& copy) const {
    const auto row = image.row(y_);
    copy.assign(row.begin(), row.end());
    copy.resize(row.size() + kRoom);
    return copy.data();
  }

  const RgbdFrame& frame_;
  CameraTexture& texture_;
  int width_, y_ = 0;
  bool is_copy_ = false;
  std::vector<std::uint16_t> depths_;
  std::vector<DepthState> states_;
  std::vector<Rgb8> colors_;
  std::vector<std::uint32_t> texels_;
};

}  // namespace

void measure_incidence(const InverseDepth& inverse, const PlanarBlocks& blocks, const CameraModel& camera,
                       Image<float>& incidences) {
  incidences.resize((inverse.width + kCell - 1) / kCell, (inverse.height + kCell - 1) / kCell);
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const Image<Plane>& planar = blocks.planes[kCellLevel];
  for (int j = 0; j < incidences.height(); ++j) {
    for (int i = 0; i < incidences.width(); ++i) {
      const bool has_block = i < planar.width() && j < planar.height();
      const Plane plane =
          has_block && planar(i, j).is_planar() ? planar(i, j) : fit_cell(inverse, i * kCell, j * kCell);
      // The lens distortion is ignored: it turns a cell's ray far less than noise turns its plane.
      const float x = (static_cast<float>(i * kCell + kCell / 2) - cx) / fx;
      const float y = (static_cast<float>(j * kCell + kCell / 2) - cy) / fy;
      incidences(i, j) =
          plane.is_planar() ? cos_theta(plane.w, plane.dx * fx, plane.dy * fy, x, y) : kUnknownIncidence;
    }
  }
}

void make_texture(const RgbdFrame& frame, const Image<float>& incidences,
                  const Eigen::Matrix<float, 3, 4>& color_correction, CameraTexture& texture) {
  const int width = frame.depth.width(), height = frame.depth.height();
  texture.resize(width + 1, height + 1);
  const ColorCorrector matched(color_correction);
  const std::vector<float> fades = fades_across(width);
  std::vector<float> between_rows, incidence_row;
  Row row(frame, texture);
  for (int y = 0; y < height; ++y) {
    interpolate_row(incidences, y, between_rows, incidence_row);
    // The first value is a repeated one. It lies half a cell to the left of pixel 0.
    const float* const incidence = incidence_row.data() + kCell / 2;
    const Floats fade = all(border_fade(std::min(y, height - 1 - y), width));
    row.begin(y);
    for (int x = 0; x < width; x += kLanes) {
      const Floats incidences_here = load<Floats>(incidence + x);
      const Ints color = row.colors ? matched(unpack(row.colors + x)) : shade(incidences_here);
      store(row.texels + x, color | weight(incidences_here * smaller(load<Floats>(&fades[x]), fade),
                                           unpack(row.states + x), unpack(row.depths + x)));
    }
    row.end();
  }
  const auto last = texture.row(height - 1);
  std::copy(last.begin(), last.end(), texture.row(height).begin());
}

}  // namespace copresence::renderer
