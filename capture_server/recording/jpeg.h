#pragma once

// JPEG pictures of recordings, by libjpeg-turbo with its exact transform: the bytes are those that every program on top of
// that library writes and the pixels those that OpenNI2's player shows. Thread: distinct objects are independent.

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

  /// `quality` is 1 to 100; colour is stored at half the resolution both ways (4:2:0), as cameras do. `bytes` is
  /// overwritten. Fails with kUnsupported and the library's reason: too large a picture, or none at all.
  Result<void> encode(const ColorImage& image, int quality, std::vector<std::uint8_t>& bytes);

 private:
  struct Close {
    void operator()(void* codec) const;
  };
  std::unique_ptr<void, Close> codec_;
};

/// Decodes bytes that nobody has checked. False where they are no JPEG picture of exactly `image`'s size, or one of more
/// than 500 scans; what damage
/// leaves of a picture is shown, as players do. `image` then holds anything.
bool decode_jpeg(std::span<const std::uint8_t> bytes, ColorImage& image);

}  // namespace copresence::recording
