#pragma once

// The list of all depth codecs by name.

#include <memory>
#include <span>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"
#include "common/frame/picture.h"

namespace copresence::depth {

struct CodecEntry {
  std::string_view name;
  PixelFormat picture;  ///< Format of its pictures.
  bool has_period;      ///< True if the codec takes "NAME:period=METRES".
  std::unique_ptr<PlaneEncoder> (*make_encoder)(std::string_view name, double period_m,
                                                const DepthFormat& format);
  Result<std::unique_ptr<PlaneDecoder>> (*make_decoder)(const DepthCodecDescription& description,
                                                        const DepthFormat& format);
};

std::span<const CodecEntry> codec_catalogue();

/// Fails with kInvalid for an unknown name. The message lists the known names.
Result<const CodecEntry*> find_codec(std::string_view name);

/// Makes the encoder that `text` from a command line names, NAME or NAME:period=METRES. Fails with
/// kInvalid for an unknown name or parameter, or an unsuitable period.
Result<std::unique_ptr<PlaneEncoder>> make_encoder(std::string_view text, const DepthFormat& format);

}  // namespace copresence::depth
