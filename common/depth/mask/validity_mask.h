#pragma once

// The state mask: which pixels are measured, filled or holes, lossless, in about a tenth of a bit for a pixel
// at an edge and next to nothing elsewhere.
//
// A pixel's state is written as one or two decisions (measured? if not, filled?), each range-coded with the
// probability learnt for its neighbourhood: pixels above and to the left in this frame, all around it in the
// frame before. A run of pixels whose whole neighbourhood is of one state costs one decision: all as
// expected? docs/internals/codecs.md draws it.
//
// Both sides learn alike and keep what they learnt from frame to frame, up to the next complete mask. The
// bytes carry no check of their own (side_data_seal.h has it): any bytes decode to some mask, in bounded
// time.
//
// Thread: distinct objects are independent.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"

namespace copresence::depth {

struct ValidityMaskMemory;  // what was learnt so far, the same on both sides

class ValidityMaskEncoder {
 public:
  /// Requires 2 <= width, height <= 4096.
  ValidityMaskEncoder(int width, int height);
  ~ValidityMaskEncoder();
  ValidityMaskEncoder(ValidityMaskEncoder&&) noexcept;
  ValidityMaskEncoder& operator=(ValidityMaskEncoder&&) noexcept;

  /// Appends the coded states to `out`. `complete`: without use of earlier frames; the first must be.
  /// Requires the shape given to the constructor.
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

  /// `states` gets the shape given to the constructor. `complete` as in encoding.
  void decode(std::span<const std::uint8_t> bytes, bool complete, StateImage& states);

 private:
  std::unique_ptr<ValidityMaskMemory> memory_;
};

}  // namespace copresence::depth
