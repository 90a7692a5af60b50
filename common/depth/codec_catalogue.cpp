#include "common/depth/codec_catalogue.h"

#include <array>
#include <string>

#include "common/depth/accuracy_codec.h"
#include "common/depth/quantized_codec.h"
#include "common/depth/spiral_codec.h"

namespace copresence::depth {
namespace {

template <PixelFormat kPicture>
constexpr CodecEntry accuracy(std::string_view name) {
  return {name, kPicture,
          [](std::string_view, const DepthFormat& format) { return make_accuracy_encoder(format, kPicture); },
          make_accuracy_decoder};
}

template <bool kFold, bool kFullChroma, bool kFilter>
constexpr CodecEntry spiral(std::string_view name) {
  return {name, kFullChroma ? PixelFormat::kYuv444 : PixelFormat::kYuv420,
          [](std::string_view own, const DepthFormat& format) {
            return make_spiral_encoder(own, SpiralVariant{kFold, kFullChroma, kFilter}, format);
          },
          [](const DepthCodecDescription& description, const DepthFormat& format) {
            return make_spiral_decoder(SpiralVariant{kFold, kFullChroma, kFilter}, description, format);
          }};
}

template <std::unique_ptr<PlaneEncoder> (*kMake)(const DepthFormat&)>
constexpr CodecEntry by_levels(std::string_view name) {
  return {
      name, PixelFormat::kGray10, [](std::string_view, const DepthFormat& format) { return kMake(format); },
      [](const DepthCodecDescription&, const DepthFormat& format) -> Result<std::unique_ptr<PlaneDecoder>> {
        return make_quantized_decoder(format);
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

}  // namespace copresence::depth
