#pragma once

// All depth codecs by name: the one place that knows them all.

#include <memory>
#include <span>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"
#include "common/frame/picture.h"

namespace copresence::depth {

struct CodecEntry {
  std::string_view name;
  PixelFormat picture;  ///< of its pictures
  bool has_period;      ///< takes "NAME:period=METRES"
  std::unique_ptr<PlaneEncoder> (*make_encoder)(std::string_view name, double period_m,
                                                const DepthFormat& format);
  Result<std::unique_ptr<PlaneDecoder>> (*make_decoder)(const DepthCodecDescription& description,
                                                        const DepthFormat& format);
};

std::span<const CodecEntry> codec_catalogue();

/// Fails (kInvalid) on an unknown name, with a sentence that lists the known ones.
Result<const CodecEntry*> find_codec(std::string_view name);

/// A codec's encoder from what a person wrote: NAME or, where the codec has a period, NAME:period=METRES.
/// Fails (kInvalid) as find_codec() does, on parameters that the codec does not have and on a period that does not fit.
Result<std::unique_ptr<PlaneEncoder>> make_encoder(std::string_view text, const DepthFormat& format);

}  // namespace copresence::depth
