#include "common/depth/chroma/phase_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "common/depth/chroma/chroma_block.h"

namespace copresence::depth {
namespace {

constexpr double kPi = std::numbers::pi;

// The formulas of the waves, shared by encoder and decoder.
struct Waves {
  Wave wave;
  double near, far, period;  // In the stream's unit.

  double periods() const { return std::ceil((far - near) / period); }
  double stair() const { return 255 / periods(); }  // S of eq. 2.7.

  // Ha and Hb of eq. 2.9: triangle waves, each linear over half a period.
  double u(double phase) const {
    return wave == Wave::kSine ? 0.5 * (1 + std::sin(2 * kPi * phase)) : triangle(phase);
  }
  double v(double phase) const {
    return wave == Wave::kSine ? 0.5 * (1 + std::cos(2 * kPi * phase)) : triangle(phase - 0.25);
  }
  double luma(double x) const {
    if (wave == Wave::kTriangle) return 255 * x / (far - near);
    const double count = std::floor(x / period), S = stair();
    return S * count + S / 2 - (S - 2) / 2 * std::cos(kPi * (x / period - count));
  }

  // The number of whole periods is round(coarse(luma) - share(phase)).
  double coarse(int luma) const {
    return wave == Wave::kTriangle ? luma / 255.0 * (far - near) / period : luma / stair() - 0.5;
  }
  double share(double phase) const {
    return wave == Wave::kTriangle ? phase : -(stair() - 2) / (2 * stair()) * std::cos(kPi * phase);
  }

  double phase(double u, double v) const {
    const double x = u - 0.5, y = v - 0.5;
    double turn = 0;
    if (wave == Wave::kSine) {
      turn = std::atan2(x, y) / (2 * kPi);
    } else if (std::abs(x) <= std::abs(y)) {  // Use the triangle wave that is nearer to its middle value.
      turn = y < 0 ? u / 2 : 1 - u / 2;
    } else {
      turn = x > 0 ? 0.25 + v / 2 : 1.25 - v / 2;
    }
    return turn - std::floor(turn);
  }

 private:
  static double triangle(double phase) {
    const double t = 2 * (phase - std::floor(phase));
    return t <= 1 ? t : 2 - t;
  }
};

std::uint8_t sample(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

class PhaseEncoder final : public PlaneEncoder {
 public:
  PhaseEncoder(std::string_view name, const Waves& waves, DepthRangeUnits range)
      : name_(name), waves_(waves) {
    samples_.resize(65536);
    for (int z = range.near; z <= range.far; ++z) {
      const double x = z - waves.near, phase = x / waves.period - std::floor(x / waves.period);
      samples_[z] = {sample(waves.luma(x)), sample(255 * waves.u(phase)), sample(255 * waves.v(phase))};
    }
  }

  DepthCodecDescription description() const override {
    return {
        name_, PixelFormat::kYuv420, {{"near", waves_.near}, {"far", waves_.far}, {"period", waves_.period}}};
  }

  Result<void> encode(const DepthImage& depth, const StateImage& states, PlanarDepth& out) override {
    out.picture = Picture(PixelFormat::kYuv420, depth.width(), depth.height());
    std::uint8_t* const y = out.picture.plane8(0).data();
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) y[i] = samples_[depth.data()[i]].y;
    std::uint8_t* u = out.picture.plane8(1).data();
    std::uint8_t* v = out.picture.plane8(2).data();
    const int tolerance = static_cast<int>(waves_.period / 8);
    for (int row = 0; row < depth.height(); row += 2) {
      for (int column = 0; column < depth.width(); column += 2) {
        const auto z = static_cast<std::size_t>(agreed_value(depth, states, column, row, tolerance));
        *u++ = samples_[z].u;
        *v++ = samples_[z].v;
      }
    }
    return {};
  }

 private:
  struct Sample {
    std::uint8_t y, u, v;
  };
  std::string name_;
  Waves waves_;
  std::vector<Sample> samples_;  // Indexed by depth.
};

class PhaseDecoder final : public PlaneDecoder {
 public:
  PhaseDecoder(const Waves& waves, DepthRangeUnits allowed)
      : near_(static_cast<float>(waves.near)), period_(static_cast<float>(waves.period)), allowed_(allowed) {
    for (int luma = 0; luma < 256; ++luma) coarse_[luma] = static_cast<float>(waves.coarse(luma));
    for (int u = 0; u < 256; ++u) {
      for (int v = 0; v < 256; ++v) {
        phase_of_uv_.push_back(static_cast<std::uint16_t>(waves.phase(u / 255.0, v / 255.0) * kPhases));
      }
    }
    for (int phase = 0; phase < kPhases; ++phase) {
      share_.push_back(static_cast<float>(waves.share((phase + 0.5) / kPhases)));
    }
  }

  Result<void> decode(const PlanarDepth& in, const StateImage&, DepthImage& out) override {
    const Picture& picture = in.picture;
    const int width = out.width();
    const auto samples = static_cast<std::size_t>(width / 2);
    share_of_pixel_.resize(static_cast<std::size_t>(width));
    phase_of_pixel_.resize(static_cast<std::size_t>(width));
    for (int y = 0; y < out.height(); ++y) {
      if (y % 2 == 0) {
        const std::uint8_t* const u = picture.plane8(1).data() + static_cast<std::size_t>(y / 2) * samples;
        const std::uint8_t* const v = picture.plane8(2).data() + static_cast<std::size_t>(y / 2) * samples;
        for (std::size_t x = 0; x < samples; ++x) {
          const std::uint16_t phase = phase_of_uv_[u[x] * 256u + v[x]];
          share_of_pixel_[2 * x] = share_of_pixel_[2 * x + 1] = share_[phase];
          phase_of_pixel_[2 * x] = phase_of_pixel_[2 * x + 1] = (static_cast<float>(phase) + 0.5f) / kPhases;
        }
      }
      const std::uint8_t* const luma = picture.plane8(0).data() + static_cast<std::size_t>(y) * width;
      std::uint16_t* const z = out.row(y).data();
      for (int x = 0; x < width; ++x) {
        // Rounds by truncating a positive number, which vector instructions can do.
        const int count = static_cast<int>(coarse_[luma[x]] - share_of_pixel_[x] + 1.5f) - 1;
        const float depth = near_ + period_ * (static_cast<float>(count) + phase_of_pixel_[x]) + 0.5f;
        z[x] =
            static_cast<std::uint16_t>(std::min<float>(std::max<float>(depth, allowed_.near), allowed_.far));
      }
    }
    return {};
  }

 private:
  static constexpr int kPhases = 8192;

  float near_, period_;
  DepthRangeUnits allowed_;
  std::array<float, 256> coarse_{};
  std::vector<std::uint16_t> phase_of_uv_;  // Phase at entry u * 256 + v, in units of 1/kPhases.
  std::vector<float> share_;                // Indexed by phase.
  std::vector<float> share_of_pixel_, phase_of_pixel_;
};

}  // namespace

Result<void> check_period(double period_m, const DepthFormat& format) {
  const double range_m = format.range.far_m - format.range.near_m;
  if (period_m >= range_m / kMostPeriods && period_m <= range_m) return {};
  std::ostringstream why;
  why << "a period of " << period_m << " m does not fit the depth range: give " << range_m / kMostPeriods
      << " to " << range_m;
  return fail(ErrorCode::kInvalid, why.str());
}

std::unique_ptr<PlaneEncoder> make_phase_encoder(std::string_view name, Wave wave, double period_m,
                                                 const DepthFormat& format) {
  const DepthRangeUnits range = format.units();
  const Waves waves{wave, double(range.near), double(range.far), period_m / metres_per_unit(format.unit)};
  return std::make_unique<PhaseEncoder>(name, waves, range);
}

Result<std::unique_ptr<PlaneDecoder>> make_phase_decoder(Wave wave, const DepthCodecDescription& description,
                                                         const DepthFormat& format) {
  const auto range = described_range(description);
  if (!range) return fail(range.error());
  const double span = range->far - range->near;
  const auto period = described(description, "period", span / (kMostPeriods + 1), span + 1);
  if (!period) return fail(period.error());
  return std::make_unique<PhaseDecoder>(Waves{wave, double(range->near), double(range->far), *period},
                                        format.units());
}

}  // namespace copresence::depth
