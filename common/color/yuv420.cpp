#include "common/color/yuv420.h"

#include <algorithm>
#include <cassert>

namespace copresence::color {
namespace {

// Coefficients in 1/65536. Each row sums to 65536 or to 0, which is what keeps greys exact.
constexpr int kShift = 16;
constexpr int kYr = 19595, kYg = 38470, kYb = 7471;
constexpr int kUr = -11058, kUg = -21710, kUb = 32768;
constexpr int kVr = 32768, kVg = -27439, kVb = -5329;
static_assert(kYr + kYg + kYb == 1 << kShift && kUr + kUg + kUb == 0 && kVr + kVg + kVb == 0);
constexpr int kRv = 91881, kGu = -22554, kGv = -46802, kBu = 116130;

// Rows are cut into tiles that stay in the first-level cache: loops over plain arrays that a compiler turns
// into SIMD.
constexpr int kTile = 128;

std::uint8_t to_byte(int value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0, 255));
}

struct Channels {
  std::uint8_t r[kTile], g[kTile], b[kTile];
};

void split(const Rgb8* __restrict rgb, int count, Channels& __restrict out) {
  for (int x = 0; x < count; ++x) {
    out.r[x] = rgb[x].r;
    out.g[x] = rgb[x].g;
    out.b[x] = rgb[x].b;
  }
}

void luma(const Channels& __restrict in, int count, std::uint8_t* __restrict y) {
  for (int x = 0; x < count; ++x) {
    y[x] = static_cast<std::uint8_t>((kYr * in.r[x] + kYg * in.g[x] + kYb * in.b[x] + (1 << (kShift - 1))) >>
                                     kShift);
  }
}

/// Sums over 2x2 pixels: 0 to 1020.
void halve(const std::uint8_t* __restrict upper, const std::uint8_t* __restrict lower, int count,
           std::uint16_t* __restrict sums) {
  for (int x = 0; x < count; ++x) {
    sums[x] = static_cast<std::uint16_t>(upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
  }
}

template <int kR, int kG, int kB>
void chroma(const std::uint16_t* __restrict r, const std::uint16_t* __restrict g,
            const std::uint16_t* __restrict b, int count, std::uint8_t* __restrict out) {
  constexpr int kSumShift = kShift + 2;
  constexpr int kOffset = (128 << kSumShift) + (1 << (kSumShift - 1));
  for (int x = 0; x < count; ++x)
    out[x] = to_byte((kR * r[x] + kG * g[x] + kB * b[x] + kOffset) >> kSumShift);
}

/// What chroma adds to luma for each channel, already doubled along the row.
struct Tint {
  std::int16_t r[kTile], g[kTile], b[kTile];
};

void tint(const std::uint8_t* __restrict u, const std::uint8_t* __restrict v, int count,
          Tint& __restrict out) {
  constexpr int kHalf = 1 << (kShift - 1);
  for (int x = 0; x < count; ++x) {
    const int cb = u[x] - 128, cr = v[x] - 128;
    const auto r = static_cast<std::int16_t>((kRv * cr + kHalf) >> kShift);
    const auto g = static_cast<std::int16_t>((kGu * cb + kGv * cr + kHalf) >> kShift);
    const auto b = static_cast<std::int16_t>((kBu * cb + kHalf) >> kShift);
    out.r[2 * x] = r, out.r[2 * x + 1] = r;
    out.g[2 * x] = g, out.g[2 * x + 1] = g;
    out.b[2 * x] = b, out.b[2 * x + 1] = b;
  }
}

void join(const std::uint8_t* __restrict y, const Tint& __restrict tint, int count, Rgb8* __restrict rgb) {
  Channels channels;
  for (int x = 0; x < count; ++x) {
    channels.r[x] = to_byte(static_cast<std::int16_t>(y[x] + tint.r[x]));
    channels.g[x] = to_byte(static_cast<std::int16_t>(y[x] + tint.g[x]));
    channels.b[x] = to_byte(static_cast<std::int16_t>(y[x] + tint.b[x]));
  }
  for (int x = 0; x < count; ++x) {
    rgb[x].r = channels.r[x];
    rgb[x].g = channels.g[x];
    rgb[x].b = channels.b[x];
  }
}

}  // namespace

void rgb_to_yuv420(const ColorImage& image, Picture& picture) {
  const int width = image.width(), height = image.height();
  if (picture.format() != PixelFormat::kYuv420 || picture.width() != width || picture.height() != height) {
    picture = Picture(PixelFormat::kYuv420, width, height);
  }
  std::uint8_t* const y = picture.plane8(0).data();
  std::uint8_t* const u = picture.plane8(1).data();
  std::uint8_t* const v = picture.plane8(2).data();
  for (int row = 0; row < height; row += 2) {
    for (int left = 0; left < width; left += kTile) {
      const int count = std::min(kTile, width - left);
      const std::size_t upper_at = static_cast<std::size_t>(row) * width + left, lower_at = upper_at + width;
      Channels upper, lower;
      split(image.data() + upper_at, count, upper);
      split(image.data() + lower_at, count, lower);
      luma(upper, count, y + upper_at);
      luma(lower, count, y + lower_at);
      std::uint16_t r[kTile / 2], g[kTile / 2], b[kTile / 2];
      halve(upper.r, lower.r, count / 2, r);
      halve(upper.g, lower.g, count / 2, g);
      halve(upper.b, lower.b, count / 2, b);
      const std::size_t chroma_at = static_cast<std::size_t>(row / 2) * (width / 2) + left / 2;
      chroma<kUr, kUg, kUb>(r, g, b, count / 2, u + chroma_at);
      chroma<kVr, kVg, kVb>(r, g, b, count / 2, v + chroma_at);
    }
  }
}

void yuv420_to_rgb(const Picture& picture, ColorImage& image) {
  assert(picture.format() == PixelFormat::kYuv420);
  const int width = picture.width(), height = picture.height();
  image.resize(width, height);
  const std::uint8_t* const y = picture.plane8(0).data();
  const std::uint8_t* const u = picture.plane8(1).data();
  const std::uint8_t* const v = picture.plane8(2).data();
  for (int row = 0; row < height; row += 2) {
    for (int left = 0; left < width; left += kTile) {
      const int count = std::min(kTile, width - left);
      const std::size_t chroma_at = static_cast<std::size_t>(row / 2) * (width / 2) + left / 2;
      const std::size_t upper_at = static_cast<std::size_t>(row) * width + left, lower_at = upper_at + width;
      Tint added;
      tint(u + chroma_at, v + chroma_at, count / 2, added);
      join(y + upper_at, added, count, image.data() + upper_at);
      join(y + lower_at, added, count, image.data() + lower_at);
    }
  }
}

}  // namespace copresence::color
