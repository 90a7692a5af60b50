#include "common/color/yuv420.h"

#include <algorithm>
#include <cassert>

namespace copresence::color {
namespace {

// Coefficients in units of 1/65536. Each row of the colour matrix sums to 65536 or to 0, which
// makes greys exact. Each chroma coefficient is positive for one channel and negative for the other
// two.
constexpr int kShift = 16;
constexpr std::uint16_t kYr = 19595, kYg = 38470, kYb = 7471;
constexpr std::uint16_t kUr = 11058, kUg = 21710;
constexpr std::uint16_t kVg = 27439, kVb = 5329;
static_assert(kYr + kYg + kYb == 1 << kShift && kUr + kUg == 1 << (kShift - 1) &&
              kVg + kVb == 1 << (kShift - 1));
constexpr int kRv = 91881, kGu = -22554, kGv = -46802, kBu = 116130;

// Rows are processed in tiles that stay in the first-level cache. Loops over plain arrays let the
// compiler use vector instructions.
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

/// Multiplies and rounds down. Compilers multiply sixteen of these 16-bit numbers at a time.
std::uint16_t share(int of, std::uint16_t coefficient) {
  return static_cast<std::uint16_t>(
      static_cast<std::uint32_t>(static_cast<std::uint16_t>(of)) * coefficient >> kShift);
}

void luma(const Channels& __restrict in, int count, std::uint8_t* __restrict y) {
  constexpr int kBits = 8;  // Fractional bits.
  // Adds 1/2 for rounding, and half of the largest error that rounding down three products causes.
  constexpr int kRounding = (1 << (kBits - 1)) + 1;
  for (int x = 0; x < count; ++x) {
    const auto sum = static_cast<std::uint16_t>(share(in.r[x] << kBits, kYr) + share(in.g[x] << kBits, kYg) +
                                                share(in.b[x] << kBits, kYb) + kRounding);
    y[x] = static_cast<std::uint8_t>(sum >> kBits);
  }
}

constexpr int kChromaBits = 7;  // Fractional bits; values from 0 to 256 then fit into 16 bits.

/// Computes means over 2x2 pixels.
void halve(const std::uint8_t* __restrict upper, const std::uint8_t* __restrict lower, int count,
           std::uint16_t* __restrict means) {
  for (int x = 0; x < count; ++x) {
    const auto sum =
        static_cast<std::uint16_t>(upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
    means[x] = static_cast<std::uint16_t>(sum << (kChromaBits - 2));
  }
}

/// Computes U or V. `more` is the channel with the coefficient 1/2: blue for U, red for V.
template <std::uint16_t kLess, std::uint16_t kLeast>
void chroma(const std::uint16_t* __restrict more, const std::uint16_t* __restrict less,
            const std::uint16_t* __restrict least, int count, std::uint8_t* __restrict out) {
  constexpr int kZero = (128 << kChromaBits) + (1 << (kChromaBits - 1));
  constexpr std::uint16_t kMost = 255;
  static_assert(kLess + kLeast == 1 << (kShift - 1));
  for (int x = 0; x < count; ++x) {
    const auto half = static_cast<std::uint16_t>(more[x] >> 1);
    const auto sum =
        static_cast<std::uint16_t>(kZero + half - share(less[x], kLess) - share(least[x], kLeast));
    out[x] = static_cast<std::uint8_t>(std::min(static_cast<std::uint16_t>(sum >> kChromaBits), kMost));
  }
}

/// The term that chroma adds to each channel, repeated for both pixels of a sample along the row.
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
      chroma<kUg, kUr>(b, g, r, count / 2, u + chroma_at);
      chroma<kVg, kVb>(r, g, b, count / 2, v + chroma_at);
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
