#include "common/depth/spiral_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/depth/chroma_block.h"
#include "common/depth/description.h"
#include "common/depth/spiral_filter.h"
#include "common/depth/spiral_points.h"

namespace copresence::depth {
namespace {

constexpr int kCodes = 8192;       // 13 bits
constexpr int kSameSurface = 128;  // codes that pixels of one surface under one chroma sample may lie apart

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
  // Y for a pixel whose chroma says `upper`.
  std::uint8_t luma(unsigned coded, unsigned upper) const {
    return static_cast<std::uint8_t>(coded ^ (variant_.fold && (upper & 1) ? 255u : 0u));
  }

  void write_full(Picture& picture) const {
    std::uint8_t* const y = picture.plane8(0).data();
    std::uint8_t* const u = picture.plane8(1).data();
    std::uint8_t* const v = picture.plane8(2).data();
    for (std::size_t i = 0; i < coded_.pixels().size(); ++i) {
      const unsigned coded = coded_.data()[i], upper = coded >> 8;
      y[i] = luma(coded, upper);
      u[i] = points_[upper].u;
      v[i] = points_[upper].v;
    }
  }

  void write_voted(const StateImage& states, Picture& picture) const {
    const int width = coded_.width();
    std::uint8_t* u = picture.plane8(1).data();
    std::uint8_t* v = picture.plane8(2).data();
    for (int y = 0; y < coded_.height(); y += 2) {
      std::uint8_t* const line = picture.plane8(0).data() + static_cast<std::size_t>(y) * width;
      for (int x = 0; x < width; x += 2) {
        const auto voted = static_cast<unsigned>(agreed_value(coded_, states, x, y, kSameSurface)) >> 8;
        *u++ = points_[voted].u;
        *v++ = points_[voted].v;
        for (int row = 0; row < 2; ++row) {
          for (int column = 0; column < 2; ++column) {
            line[row * width + x + column] = luma_beside(coded_(x + column, y + row), voted);
          }
        }
      }
    }
  }

  // Y for a pixel that was perhaps outvoted. On the same surface the end of the voted part is nearer to it
  // than anything that its own lower bits could be taken for; beyond an edge they are kept, and the filter
  // finds their upper part.
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
    read_upper_parts(picture);
    const int width = out.width(), block = variant_.full_chroma ? 1 : 2;
    spread_.resize(static_cast<std::size_t>(width));
    for (int y = 0; y < out.height(); ++y) {
      if (y % block == 0) {
        const std::uint8_t* const upper = upper_.row(y / block).data();
        for (int x = 0; x < width; ++x) {
          const unsigned part = upper[x / block];
          spread_[x] = static_cast<std::uint16_t>(part << 8 | (variant_.fold && (part & 1) ? 255u : 0u));
        }
      }
      const std::uint8_t* const luma = picture.plane8(0).data() + static_cast<std::size_t>(y) * width;
      std::uint16_t* const coded = out.row(y).data();
      for (int x = 0; x < width; ++x) coded[x] = static_cast<std::uint16_t>(spread_[x] ^ luma[x]);
    }
    if (variant_.filter) {
      find_doubtful(picture);
      correct_upper_bits(out, states, doubtful_, variant_.fold);
    }
    for (std::uint16_t& z : out.pixels()) z = depth_of_coded_[z];
    return {};
  }

 private:
  void read_upper_parts(const Picture& picture) {
    upper_.resize(picture.plane_width(1), picture.plane_height(1));
    const std::uint8_t* const u = picture.plane8(1).data();
    const std::uint8_t* const v = picture.plane8(2).data();
    for (std::size_t i = 0; i < upper_.pixels().size(); ++i) upper_.data()[i] = nearest_[u[i] * 256u + v[i]];
  }

  // A chroma sample may be wrong for its pixels where video coding moved it off its point, and, if several
  // pixels voted on it, where its neighbours say something else.
  void find_doubtful(const Picture& picture) {
    const int width = upper_.width(), height = upper_.height();
    const std::uint8_t* const u = picture.plane8(1).data();
    const std::uint8_t* const v = picture.plane8(2).data();
    doubtful_.resize(width, height);
    for (std::size_t i = 0; i < upper_.pixels().size(); ++i) {
      const ChromaPoint point = points_[upper_.data()[i]];
      doubtful_.data()[i] = std::abs(point.u - u[i]) + std::abs(point.v - v[i]) > kMoved;
    }
    if (variant_.full_chroma) return;
    for (int y = 0; y < height; ++y) {
      const std::uint8_t* const here = upper_.row(y).data();
      const std::uint8_t* const above = upper_.row(std::max(y - 1, 0)).data();
      const std::uint8_t* const below = upper_.row(std::min(y + 1, height - 1)).data();
      std::uint8_t* const doubt = doubtful_.row(y).data();
      for (int x = 0; x < width; ++x) {
        const int left = std::max(x - 1, 0), right = std::min(x + 1, width - 1);
        doubt[x] |= (here[x] != here[left]) | (here[x] != here[right]) | (here[x] != above[x]) |
                    (here[x] != below[x]);
      }
    }
  }

  static constexpr int kMoved = 8;  // codes in U and V together; the points lie 38 apart

  SpiralVariant variant_;
  std::array<ChromaPoint, kSpiralPoints> points_ = spiral_points();
  std::vector<std::uint8_t> nearest_;
  std::vector<std::uint16_t> depth_of_coded_;
  Image<std::uint8_t> upper_, doubtful_;  // of every chroma sample
  std::vector<std::uint16_t> spread_;  // a row's upper bits, with the lower ones set where luma is mirrored
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
