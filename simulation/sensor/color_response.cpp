#include "simulation/sensor/color_response.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "simulation/scene/noise.h"

namespace copresence::simulation {
namespace {

constexpr int kTile = 256;            // In pixels. The position of the tile changes with each frame.
constexpr float kGrain = 1.3f;        // Standard deviation of the noise, of 255.
constexpr float kVignetting = 0.12f;  // Share of the light that the corners lose.
constexpr float kScreenGamma = 2.4f;  // Approximate exponent between pixel value and light.
// Automatic exposure: the light of the other cameras, relative to camera 0.
constexpr float kLeastLight = 0.35f, kMostLight = 0.65f;

}  // namespace

ColorResponse::ColorResponse(int width, int height, std::uint32_t seed, std::uint32_t camera)
    : seed_(hash(seed, camera, 0xC0)) {
  const float strength = camera == 0 ? 0.15f : 1.0f;
  const auto draw = [&](std::uint32_t what) { return strength * (2 * unit(hash(seed_, what)) - 1); };
  const float light = camera == 0 ? 1.0f : kLeastLight + (kMostLight - kLeastLight) * unit(hash(seed_, 40));
  const float exposure = std::pow(light, 1 / kScreenGamma);
  mixing_.setIdentity();
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::uint32_t>(c);
    mixing_(c, c) = 1 + 0.12f * draw(channel);
    for (int d = 0; d < 3; ++d) {
      if (d != c) mixing_(c, d) = 0.04f * draw(10 + 3 * channel + static_cast<std::uint32_t>(d));
    }
    mixing_.row(c) *= exposure;
    offset_[c] = 5.0f / 255 * draw(20 + channel);
    gamma_[c] = 1 + 0.08f * draw(30 + channel);
    offset_fixed_[static_cast<std::size_t>(c)] =
        static_cast<std::int32_t>(std::lround(offset_[c] * 255 * 16));
    for (std::size_t value = 0; value < 256; ++value) {
      curve_[value][static_cast<std::size_t>(c)] = static_cast<std::int16_t>(
          std::lround(16 * 255 * std::pow(static_cast<float>(value) / 255, gamma_[c])));
    }
    for (int d = 0; d < 3; ++d) {
      mixing_fixed_[static_cast<std::size_t>(3 * c + d)] =
          static_cast<std::int32_t>(std::lround(4096 * mixing_(c, d)));
    }
  }
  const float center_x = 0.5f * static_cast<float>(width - 1),
              center_y = 0.5f * static_cast<float>(height - 1);
  const float diagonal = center_x * center_x + center_y * center_y;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float dx = static_cast<float>(x) - center_x, dy = static_cast<float>(y) - center_y;
      vignetting_.push_back(static_cast<std::uint16_t>(
          std::lround(4096 * std::pow(1 - kVignetting * (dx * dx + dy * dy) / diagonal, 1 / kScreenGamma))));
    }
  }
  for (std::uint32_t i = 0; i < 3 * kTile * kTile; ++i) {
    grain_.push_back(static_cast<std::int8_t>(std::lround(16 * kGrain * normal(hash(seed_, 100, i)))));
  }
}

Eigen::Vector3f ColorResponse::respond_to(const Eigen::Vector3f& color) const {
  Eigen::Vector3f curved;
  for (int c = 0; c < 3; ++c) curved[c] = std::pow(std::clamp(color[c], 0.0f, 1.0f), gamma_[c]);
  return (mixing_ * curved + offset_).cwiseMax(0.0f).cwiseMin(1.0f);
}

void ColorResponse::apply_response(const ColorImage& truth, NoiseFreeColors& colors) const {
  assert(truth.pixels().size() == vignetting_.size());
  colors.resize(truth.width(), truth.height());
  const std::array<std::int32_t, 9> m = mixing_fixed_;
  const std::array<std::int32_t, 3> offset = offset_fixed_;
  const auto width = static_cast<std::size_t>(truth.width());
  // Values of one row, channel by channel, so that the loop over pixels becomes vector code.
  std::vector<std::int32_t> curved(3 * width);
  std::int32_t* __restrict red = curved.data();
  std::int32_t* __restrict green = red + width;
  std::int32_t* __restrict blue = green + width;
  for (int y = 0; y < truth.height(); ++y) {
    const Rgb8* in = truth.row(y).data();
    for (std::size_t x = 0; x < width; ++x) {
      red[x] = curve_[in[x].r][0];
      green[x] = curve_[in[x].g][1];
      blue[x] = curve_[in[x].b][2];
    }
    const std::uint16_t* __restrict vignetting = vignetting_.data() + static_cast<std::size_t>(y) * width;
    NoiseFreeColor* __restrict out = colors.row(y).data();
    for (std::size_t x = 0; x < width; ++x) {
      const auto channel = [&](std::size_t c) {
        const std::int32_t mixed =
            (m[3 * c] * red[x] + m[3 * c + 1] * green[x] + m[3 * c + 2] * blue[x]) >> 12;
        return static_cast<std::int16_t>((mixed * vignetting[x] >> 12) + offset[c] + 8);
      };
      out[x].r = channel(0);
      out[x].g = channel(1);
      out[x].b = channel(2);
    }
  }
}

void ColorResponse::add_noise(const NoiseFreeColors& colors, std::uint64_t frame,
                              std::span<Rgb8> picture) const {
  assert(colors.pixels().size() == vignetting_.size() && picture.size() == vignetting_.size());
  const auto row_values = static_cast<std::size_t>(3 * colors.width());
  const std::uint32_t position =
      hash(seed_, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32));
  const int tile_x = static_cast<int>(position % kTile), tile_y = static_cast<int>(position / kTile % kTile);
  for (int y = 0; y < colors.height(); ++y) {
    const auto* __restrict clean = reinterpret_cast<const std::int16_t*>(colors.row(y).data());
    auto* __restrict out =
        reinterpret_cast<std::uint8_t*>(picture.data()) + static_cast<std::size_t>(y) * row_values;
    const std::size_t grain_row = static_cast<std::size_t>((y + tile_y) % kTile) * 3 * kTile;
    for (std::size_t at = 0; at < row_values;) {
      const std::size_t in_tile = (at + static_cast<std::size_t>(3 * tile_x)) % (3 * kTile);
      const std::size_t count = std::min<std::size_t>(3 * kTile - in_tile, row_values - at);
      const std::int8_t* __restrict grain = grain_.data() + grain_row + in_tile;
      for (std::size_t i = 0; i < count; ++i) {
        const int noisy = (clean[at + i] + grain[i]) >> 4;
        out[at + i] = static_cast<std::uint8_t>(std::min(std::max(noisy, 0), 255));
      }
      at += count;
    }
  }
}

}  // namespace copresence::simulation
