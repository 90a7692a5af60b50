#include "common/depth/chroma/spiral_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "common/depth/chroma/chroma_block.h"
#include "common/depth/chroma/spiral_filter.h"

namespace copresence::depth {
namespace {

constexpr int kCodes = 8192;  // 13 bits.
// Pixels of a chroma sample whose codes differ by less than this are on one surface.
constexpr int kSameSurface = 128;

constexpr int kSpiralPoints = 32;
// Parameter t of the first point. Nearer to the centre, the turns would be too close.
constexpr double kFirst = 5.0;
constexpr double kRadius = 127.0;  // Radius of the last point.

struct ChromaPoint {
  std::uint8_t u, v;
};

// Arc length of the spiral, eq. 3.12 with b = 1.
double arc_length(double t) {
  return 0.5 * (t * std::sqrt(t * t + 1) + std::asinh(t));
}

// Returns the t whose arc length is `length`.
double inverse_arc_length(double length) {
  double low = 0, high = 100;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (arc_length(middle) < length ? low : high) = middle;
  }
  return low;
}

// Neighbouring points, also those on the next turn, are at least 38 codes apart.
std::array<ChromaPoint, kSpiralPoints> spiral_points() {
  // The distance between points equals the distance between turns, 2 pi b.
  const double spacing = 2 * std::numbers::pi;
  const double start = arc_length(kFirst);
  const double last = inverse_arc_length(start + spacing * (kSpiralPoints - 1));
  std::array<ChromaPoint, kSpiralPoints> points{};
  for (int i = 0; i < kSpiralPoints; ++i) {
    const double t = inverse_arc_length(start + spacing * i);
    const double r = kRadius * t / last;
    points[i] = {static_cast<std::uint8_t>(std::lround(128 + r * std::cos(t))),
                 static_cast<std::uint8_t>(std::lround(128 + r * std::sin(t)))};
  }
  return points;
}

// Limit in codes of U plus V. Video coding probably changed a sample farther from its point.
constexpr int kMoved = 8;
constexpr std::uint8_t kOffPoint = 0x80;

// Returns, for every UV at u * 256 + v, the index of the nearest point. Sets kOffPoint if UV is
// farther than kMoved from that point.
std::vector<std::uint8_t> nearest_spiral_point() {
  const auto points = spiral_points();
  std::vector<std::uint8_t> nearest(65536);
  for (int u = 0; u < 256; ++u) {
    for (int v = 0; v < 256; ++v) {
      int least = std::numeric_limits<int>::max();
      for (int i = 0; i < kSpiralPoints; ++i) {
        const int du = u - points[i].u, dv = v - points[i].v, distance = du * du + dv * dv;
        if (distance >= least) continue;
        least = distance;
        const bool off = std::abs(du) + std::abs(dv) > kMoved;
        nearest[u * 256 + v] = static_cast<std::uint8_t>(i | (off ? kOffPoint : 0));
      }
    }
  }
  return nearest;
}

class SpiralEncoder final : public PlaneEncoder {
 public:
  SpiralEncoder(std::string_view name, SpiralVariant variant, const DepthFormat& format)
      : name_(name),
        variant_(variant),
        range_(format.units()),
        points_(spiral_points()),
        coded_of_depth_(65536, 0) {
    for (int z = range_.near; z <= range_.far; ++z) {
      const double code = (kCodes - 1.0) * (z - range_.near) / (range_.far - range_.near);
      coded_of_depth_[z] = static_cast<std::uint16_t>(std::lround(code));
    }
  }

  DepthCodecDescription description() const override {
    return {name_,
            variant_.full_chroma ? PixelFormat::kYuv444 : PixelFormat::kYuv420,
            {{"near", range_.near}, {"far", range_.far}}};
  }

  Result<void> encode(const DepthImage& depth, const StateImage& states, PlanarDepth& out) override {
    const int width = depth.width(), height = depth.height();
    out.picture = Picture(variant_.full_chroma ? PixelFormat::kYuv444 : PixelFormat::kYuv420, width, height);
    coded_.resize(width, height);
    const std::size_t size = depth.pixels().size();
    for (std::size_t i = 0; i < size; ++i) coded_.data()[i] = coded_of_depth_[depth.data()[i]];
    if (variant_.full_chroma) {
      write_full(out.picture);
    } else {
      write_voted(states, out.picture);
    }
    return {};
  }

 private:
  // Returns the Y of code `coded` if the chroma sample stands for the upper bits `upper`.
  std::uint8_t luma(unsigned coded, unsigned upper) const {
    return static_cast<std::uint8_t>(coded ^ (variant_.fold && (upper & 1) ? 255u : 0u));
  }

  // Writes a row of Y for pixels whose chroma sample stands for their own upper bits.
  void write_luma_row(const std::uint16_t* coded, int width, std::uint8_t* y) const {
    const unsigned mirrored = variant_.fold ? 255 : 0;
    for (int x = 0; x < width; ++x)
      y[x] = static_cast<std::uint8_t>(coded[x] ^ ((0u - (coded[x] >> 8 & 1u)) & mirrored));
  }

  void write_full(Picture& picture) const {
    write_luma_row(coded_.data(), static_cast<int>(coded_.pixels().size()), picture.plane8(0).data());
    std::uint8_t* const u = picture.plane8(1).data();
    std::uint8_t* const v = picture.plane8(2).data();
    const std::size_t size = coded_.pixels().size();
    for (std::size_t i = 0; i < size; ++i) {
      const ChromaPoint point = points_[coded_.data()[i] >> 8];
      u[i] = point.u;
      v[i] = point.v;
    }
  }

  void write_voted(const StateImage& states, Picture& picture) const {
    const int width = coded_.width();
    std::uint8_t* u = picture.plane8(1).data();
    std::uint8_t* v = picture.plane8(2).data();
    for (int y = 0; y < coded_.height(); y += 2) {
      std::uint8_t* const line = picture.plane8(0).data() + static_cast<std::size_t>(y) * width;
      const std::uint16_t* const above = coded_.row(y).data();
      const std::uint16_t* const below = coded_.row(y + 1).data();
      write_luma_row(above, width, line);
      write_luma_row(below, width, line + width);
      for (int x = 0; x < width; x += 2) {
        unsigned voted = above[x] >> 8;
        const unsigned differ = (above[x] ^ above[x + 1]) | (above[x] ^ below[x]) | (above[x] ^ below[x + 1]);
        if (differ >> 8 != 0) {
          voted = static_cast<unsigned>(agreed_value(coded_, states, x, y, kSameSurface)) >> 8;
          for (int row = 0; row < 2; ++row) {
            for (int column = 0; column < 2; ++column)
              line[row * width + x + column] = luma_beside(coded_(x + column, y + row), voted);
          }
        }
        *u++ = points_[voted].u;
        *v++ = points_[voted].v;
      }
    }
  }

  // Returns Y of a pixel. The upper bits of its code may differ from `voted`, the upper bits in the
  // chroma sample. On the same surface, the pixel takes the nearest code with the upper bits
  // `voted`. Beyond an edge, it keeps its own lower bits, and the filter finds the upper bits.
  std::uint8_t luma_beside(int coded, unsigned voted) const {
    const int least = static_cast<int>(voted) << 8, most = least + 255;
    if (coded < least && coded >= least - kSameSurface) return luma(0u, voted);
    if (coded > most && coded <= most + kSameSurface) return luma(255u, voted);
    return luma(static_cast<unsigned>(coded), static_cast<unsigned>(coded) >> 8);
  }

  std::string name_;
  SpiralVariant variant_;
  DepthRangeUnits range_;
  std::array<ChromaPoint, kSpiralPoints> points_;
  std::vector<std::uint16_t> coded_of_depth_;
  DepthImage coded_;
};

class SpiralDecoder final : public PlaneDecoder {
 public:
  SpiralDecoder(SpiralVariant variant, DepthRangeUnits range, DepthRangeUnits allowed)
      : variant_(variant), nearest_(nearest_spiral_point()) {
    for (int code = 0; code < kCodes; ++code) {
      const double z = range.near + code * (range.far - range.near) / (kCodes - 1.0);
      depth_of_coded_.push_back(
          static_cast<std::uint16_t>(std::lround(std::clamp<double>(z, allowed.near, allowed.far))));
    }
  }

  Result<void> decode(const PlanarDepth& in, const StateImage& states, DepthImage& out) override {
    const Picture& picture = in.picture;
    read_chroma(picture);
    const int width = out.width(), block = variant_.full_chroma ? 1 : 2;
    spread_.resize(static_cast<std::size_t>(width));
    for (int y = 0; y < out.height(); ++y) {
      if (y % block == 0) spread(upper_.row(y / block).data());
      const std::uint8_t* const luma = picture.plane8(0).data() + static_cast<std::size_t>(y) * width;
      const std::uint16_t* const upper = spread_.data();
      std::uint16_t* const coded = out.row(y).data();
      for (int x = 0; x < width; ++x) coded[x] = static_cast<std::uint16_t>(upper[x] ^ luma[x]);
    }
    if (variant_.filter) {
      if (!variant_.full_chroma) doubt_votes();
      correct_upper_bits(out, states, doubtful_, variant_.fold);
    }
    const std::uint16_t* const depth = depth_of_coded_.data();
    for (std::uint16_t& z : out.pixels()) z = depth[z];
    return {};
  }

 private:
  // Reads the upper bits of every chroma sample. Marks samples that are off their spiral point as
  // doubtful.
  void read_chroma(const Picture& picture) {
    upper_.resize(picture.plane_width(1), picture.plane_height(1));
    doubtful_.resize(picture.plane_width(1), picture.plane_height(1));
    const std::uint8_t* const u = picture.plane8(1).data();
    const std::uint8_t* const v = picture.plane8(2).data();
    const std::uint8_t* const nearest = nearest_.data();
    std::uint8_t* const upper = upper_.data();
    std::uint8_t* const doubt = doubtful_.data();
    const std::size_t size = upper_.pixels().size();
    for (std::size_t i = 0; i < size; ++i) upper[i] = nearest[u[i] * 256u + v[i]];
    for (std::size_t i = 0; i < size; ++i) {
      doubt[i] = upper[i] & kOffPoint;
      upper[i] &= static_cast<std::uint8_t>(~kOffPoint);
    }
  }

  // Copies a row's upper bits to its pixels, and sets the lower bits where luma is mirrored.
  void spread(const std::uint8_t* upper) {
    std::uint16_t* const out = spread_.data();
    const std::size_t width = spread_.size();
    const unsigned mirrored = variant_.fold ? 255 : 0;
    const auto bits = [&](unsigned part) {
      return static_cast<std::uint16_t>(part << 8 | ((0u - (part & 1)) & mirrored));
    };
    if (variant_.full_chroma) {
      for (std::size_t x = 0; x < width; ++x) out[x] = bits(upper[x]);
    } else {
      for (std::size_t x = 0; x < width / 2; ++x) out[2 * x] = out[2 * x + 1] = bits(upper[x]);
    }
  }

  // Marks samples whose neighbours have other upper bits. Upper bits of such samples may be wrong
  // for some pixels.
  void doubt_votes() {
    const int width = upper_.width(), height = upper_.height();
    for (int y = 0; y < height; ++y) {
      const std::uint8_t* const here = upper_.row(y).data();
      const std::uint8_t* const above = upper_.row(std::max(y - 1, 0)).data();
      const std::uint8_t* const below = upper_.row(std::min(y + 1, height - 1)).data();
      std::uint8_t* const doubt = doubtful_.row(y).data();
      for (int x = 0; x < width; ++x)
        doubt[x] = static_cast<std::uint8_t>(doubt[x] | (here[x] ^ above[x]) | (here[x] ^ below[x]));
      for (int x = 1; x < width; ++x)
        doubt[x] = static_cast<std::uint8_t>(doubt[x] | (here[x] ^ here[x - 1]));
      for (int x = 0; x + 1 < width; ++x)
        doubt[x] = static_cast<std::uint8_t>(doubt[x] | (here[x] ^ here[x + 1]));
    }
  }

  SpiralVariant variant_;
  std::vector<std::uint8_t> nearest_;
  std::vector<std::uint16_t> depth_of_coded_;
  Image<std::uint8_t> upper_, doubtful_;  // Indexed by chroma sample.
  std::vector<std::uint16_t> spread_;     // One row from spread().
};

}  // namespace

std::unique_ptr<PlaneEncoder> make_spiral_encoder(std::string_view name, SpiralVariant variant,
                                                  const DepthFormat& format) {
  return std::make_unique<SpiralEncoder>(name, variant, format);
}

Result<std::unique_ptr<PlaneDecoder>> make_spiral_decoder(SpiralVariant variant,
                                                          const DepthCodecDescription& description,
                                                          const DepthFormat& format) {
  const auto range = described_range(description);
  if (!range) return fail(range.error());
  return std::make_unique<SpiralDecoder>(variant, *range, format.units());
}

}  // namespace copresence::depth
