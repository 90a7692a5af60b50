#pragma once

// Lossless coder for monochrome depth pictures. Lossless H.264 takes a third more bits and far
// longer.
//
// Every sample is coded as its difference from the sample on its left. A context selects the
// adaptive distribution for the difference. The context consists of four clamped differences. The
// first difference is between the samples above and on the left. The other three are between the
// sample above and the samples at the upper left, at the upper right and in the frame before. Holes
// are omitted, since both sides know the states. See docs/internals/codecs.md for the format.
//
// Encoder and decoder keep samples and distributions from frame to frame, until the next complete
// picture. The decoder cannot detect damage: it decodes any bytes to some samples in bounded time.
// The checksum of the side data (common/bitstream) protects the bytes. Thread: distinct objects are
// independent.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::depth {

struct ResidualMemory;  // State kept between frames, the same in encoder and decoder.

class ResidualEncoder {
 public:
  /// Requires kGray8 or kGray10, and sizes that a DepthFormat may have.
  ResidualEncoder(PixelFormat format, int width, int height);
  ~ResidualEncoder();
  ResidualEncoder(ResidualEncoder&&) noexcept;
  ResidualEncoder& operator=(ResidualEncoder&&) noexcept;

  /// Appends the coded samples of `picture` to `out`, without those in holes. A complete picture
  /// does not depend on earlier frames. The first picture must be complete. Requires the format and
  /// shape given to the constructor.
  void encode(const Picture& picture, const StateImage& states, bool complete,
              std::vector<std::uint8_t>& out);

 private:
  std::unique_ptr<ResidualMemory> memory_;
};

class ResidualDecoder {
 public:
  ResidualDecoder(PixelFormat format, int width, int height);
  ~ResidualDecoder();
  ResidualDecoder(ResidualDecoder&&) noexcept;
  ResidualDecoder& operator=(ResidualDecoder&&) noexcept;

  /// Decodes into `picture`, which gets the constructor's format and shape. Holes are arbitrary.
  void decode(std::span<const std::uint8_t> bytes, const StateImage& states, bool complete, Picture& picture);

 private:
  std::unique_ptr<ResidualMemory> memory_;
};

}  // namespace copresence::depth
