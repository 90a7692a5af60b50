#include "common/depth/codec_catalogue.h"

#include <array>
#include <charconv>
#include <string>

#include "common/depth/chroma/phase_codec.h"
#include "common/depth/chroma/spiral_codec.h"
#include "common/depth/levels/accuracy_codec.h"
#include "common/depth/levels/quantized_codec.h"

namespace copresence::depth {
namespace {

template <PixelFormat kPicture>
constexpr CodecEntry accuracy(std::string_view name) {
  return {name, kPicture, false,
          [](std::string_view, double, const DepthFormat& format) {
            return make_accuracy_encoder(format, kPicture);
          },
          make_accuracy_decoder};
}

template <bool kFold, bool kFullChroma, bool kFilter>
constexpr CodecEntry spiral(std::string_view name) {
  return {name, kFullChroma ? PixelFormat::kYuv444 : PixelFormat::kYuv420, false,
          [](std::string_view own, double, const DepthFormat& format) {
            return make_spiral_encoder(own, SpiralVariant{kFold, kFullChroma, kFilter}, format);
          },
          [](const DepthCodecDescription& description, const DepthFormat& format) {
            return make_spiral_decoder(SpiralVariant{kFold, kFullChroma, kFilter}, description, format);
          }};
}

template <std::unique_ptr<PlaneEncoder> (*kMake)(const DepthFormat&)>
constexpr CodecEntry by_levels(std::string_view name) {
  return {
      name, PixelFormat::kGray10, false,
      [](std::string_view, double, const DepthFormat& format) { return kMake(format); },
      [](const DepthCodecDescription&, const DepthFormat& format) -> Result<std::unique_ptr<PlaneDecoder>> {
        return make_quantized_decoder(format);
      }};
}

template <Wave kWave>
constexpr CodecEntry phase(std::string_view name) {
  return {name, PixelFormat::kYuv420, true,
          [](std::string_view own, double period_m, const DepthFormat& format) {
            return make_phase_encoder(own, kWave, period_m, format);
          },
          [](const DepthCodecDescription& description, const DepthFormat& format) {
            return make_phase_decoder(kWave, description, format);
          }};
}

constexpr std::array kCatalogue{
    by_levels<make_quantized_encoder>("quantized"),
    by_levels<make_adaptive_encoder>("adaptive"),
    accuracy<PixelFormat::kGray10>("accuracy10"),
    accuracy<PixelFormat::kGray8>("accuracy8"),
    spiral<false, false, true>("spiral"),
    spiral<true, false, true>("spiral-fold"),
    spiral<false, true, true>("spiral-444"),
    spiral<true, true, true>("spiral-fold-444"),
    spiral<false, false, false>("spiral-nofilter"),
    spiral<true, false, false>("spiral-fold-nofilter"),
    spiral<false, true, false>("spiral-444-nofilter"),
    spiral<true, true, false>("spiral-fold-444-nofilter"),
    phase<Wave::kTriangle>("triangle"),
    phase<Wave::kSine>("direct"),
};

}  // namespace

std::span<const CodecEntry> codec_catalogue() {
  return kCatalogue;
}

Result<const CodecEntry*> find_codec(std::string_view name) {
  std::string what = "there is no depth codec '" + std::string(name) + "'; choose one of";
  for (const CodecEntry& entry : kCatalogue) {
    if (entry.name == name) return &entry;
    what += ' ' + std::string(entry.name);
  }
  return fail(ErrorCode::kInvalid, what);
}

Result<std::unique_ptr<PlaneEncoder>> make_encoder(std::string_view text, const DepthFormat& format) {
  const std::size_t colon = text.find(':');
  const auto codec = find_codec(text.substr(0, colon));
  if (!codec) return fail(codec.error());
  double period_m = kPeriodM;
  if (colon != std::string_view::npos) {
    constexpr std::string_view kPeriod = "period=";
    const std::string_view parameter = text.substr(colon + 1);
    const bool known = (*codec)->has_period && parameter.starts_with(kPeriod);
    const char* const first = parameter.data() + kPeriod.size();
    const char* const last = parameter.data() + parameter.size();
    if (!known || std::from_chars(first, last, period_m).ptr != last || first == last) {
      const std::string what = (*codec)->has_period ? "takes only period=METRES" : "takes no parameters";
      return fail(ErrorCode::kInvalid, "depth codec " + std::string((*codec)->name) + ' ' + what + ", not '" +
                                           std::string(parameter) + '\'');
    }
  }
  if ((*codec)->has_period) {
    if (const auto checked = check_period(period_m, format); !checked) return fail(checked.error());
  }
  return (*codec)->make_encoder((*codec)->name, period_m, format);
}

}  // namespace copresence::depth
