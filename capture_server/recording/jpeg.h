#pragma once

// Encodes and decodes the JPEG pictures of recordings, by libjpeg-turbo with its exact transform.
// All programs that use this library write the same bytes. OpenNI2's player decodes the same
// pixels.
// Thread: one thread at a time per object.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

class JpegEncoder {
 public:
  JpegEncoder();

  /// Encodes a picture into `bytes`, which it overwrites. `quality` is 1 to 100. Colour is stored
  /// at half the resolution in both directions (4:2:0), as cameras do.
  /// Fails with kUnsupported and the library's reason if the picture is empty or too large.
  Result<void> encode(const ColorImage& image, int quality, std::vector<std::uint8_t>& bytes);

 private:
  struct Close {
    void operator()(void* codec) const;
  };
  std::unique_ptr<void, Close> codec_;
};

/// Decodes untrusted bytes. A damaged picture is decoded as far as possible. Returns false if the
/// bytes are not a JPEG picture of exactly `image`'s size, or have more than 500 scans. `image` is
/// unspecified after a failure.
bool decode_jpeg(std::span<const std::uint8_t> bytes, ColorImage& image);

}  // namespace copresence::recording
