#pragma once

// The samples of a monochrome picture where there is depth, without loss: for depth that must come back exactly, where H.264
// spends a third more bits and several times the time.
//
// Every sample is coded as its difference to the one on its left, with a distribution learnt for how the samples above, to
// the upper left, the upper right and of the frame before differ from their neighbours. Holes cost nothing: both sides know
// the states. docs/internals/codecs.md has the bytes.
//
// Both sides keep samples and distributions from frame to frame, up to the next complete picture. The bytes carry no check of
// their own (side_data_seal.h has it): any bytes decode to some samples, in bounded time.
//
// Thread: distinct objects are independent.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::depth {

struct ResidualMemory;  // what was learnt so far, the same on both sides

class ResidualEncoder {
 public:
  /// Requires kGray8 or kGray10 and sizes as of a DepthFormat.
  ResidualEncoder(PixelFormat format, int width, int height);
  ~ResidualEncoder();
  ResidualEncoder(ResidualEncoder&&) noexcept;
  ResidualEncoder& operator=(ResidualEncoder&&) noexcept;

  /// Appends the samples of `picture` where `states` is not kHole to `out`. `complete`: without use of earlier frames; the
  /// first must be. Requires the format and shape given to the constructor.
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

  /// `picture` gets the format and shape given to the constructor; its samples where `states` is kHole mean nothing.
  void decode(std::span<const std::uint8_t> bytes, const StateImage& states, bool complete, Picture& picture);

 private:
  std::unique_ptr<ResidualMemory> memory_;
};

}  // namespace copresence::depth
