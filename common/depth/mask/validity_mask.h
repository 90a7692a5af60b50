#pragma once

// Lossless coder of the validity mask: which pixels are measured, filled or holes. A pixel at an
// edge takes about a tenth of a bit, and other pixels almost nothing.
//
// A pixel's state is coded as one or two binary decisions: whether it is measured and, if not,
// whether it is filled. Each decision is range-coded with the probability learnt for the pixel's
// neighbourhood. The neighbourhood consists of pixels above and to the left in this frame, and on
// all sides in the frame before. If the whole neighbourhood of a run of pixels has one state, a
// single decision says that the run has it, too. See docs/internals/codecs.md for the format.
//
// Encoder and decoder learn the same probabilities and keep them from frame to frame, until the
// next complete mask. The decoder cannot detect damage: it decodes any bytes to some mask in
// bounded time. The checksum of the side data (common/bitstream) protects the bytes. Thread:
// distinct objects are independent.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"

namespace copresence::depth {

struct ValidityMaskMemory;  // State kept between frames, the same in encoder and decoder.

class ValidityMaskEncoder {
 public:
  /// Requires 2 <= width, height <= 4096.
  ValidityMaskEncoder(int width, int height);
  ~ValidityMaskEncoder();
  ValidityMaskEncoder(ValidityMaskEncoder&&) noexcept;
  ValidityMaskEncoder& operator=(ValidityMaskEncoder&&) noexcept;

  /// Appends the coded states to `out`. A complete mask does not depend on earlier frames. The
  /// first mask must be complete. Requires the shape given to the constructor.
  void encode(const StateImage& states, bool complete, std::vector<std::uint8_t>& out);

 private:
  std::unique_ptr<ValidityMaskMemory> memory_;
};

class ValidityMaskDecoder {
 public:
  /// Requires 2 <= width, height <= 4096.
  ValidityMaskDecoder(int width, int height);
  ~ValidityMaskDecoder();
  ValidityMaskDecoder(ValidityMaskDecoder&&) noexcept;
  ValidityMaskDecoder& operator=(ValidityMaskDecoder&&) noexcept;

  /// Decodes into `states`, which get the constructor's shape. `complete` must be as in encoding.
  void decode(std::span<const std::uint8_t> bytes, bool complete, StateImage& states);

 private:
  std::unique_ptr<ValidityMaskMemory> memory_;
};

}  // namespace copresence::depth
