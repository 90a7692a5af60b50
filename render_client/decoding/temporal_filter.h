#pragma once

// Keeps still what stands still. A Kinect measures a wall anew in every frame: levels come and go, rims of
// holes and outlines flicker, colours have grain; and a view from beside the camera turns all of it into
// motion.
//
// Depth and colour of each pixel become their means over the last frames, for as long as the pixel's block
// says that nothing moves there. A surface that comes nearer moves the mean of the block's differences, which
// noise hardly does; what moves sideways changes its colours. What moves is shown as it comes, without delay.
// Where neither the block nor a neighbour moves, a pixel that loses its depth keeps it for some frames, and a
// lone jump waits for a second frame to confirm it. When much of the picture moves, the camera does, and
// nothing is kept until a frame is like the one before it again.
//
// The idea of keeping depth by whether it changed for longer than noise does is that of temporal filters of
// depth cameras (librealsense's, for one); judging blocks, and colour as the witness, are ours. Constants
// against a Kinect v1's noise (docs/internals/simulation.md has its figures).
//
// Thread: one thread at a time per object.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::client {

class TemporalFilter {
 public:
  static constexpr int kBlock = 8;        ///< pixels a side
  static constexpr int kFrames = 8;       ///< in a mean: each new one counts for 1/kFrames at least
  static constexpr int kKeptFrames = 8;   ///< that depth outlives its last measurement
  static constexpr float kJump = 3.5F;    ///< sensor steps; what differs by more is another surface
  static constexpr float kNoise = 0.5F;   ///< sensor steps; noise explains such a mean difference of a block,
  static constexpr float kMotion = 1.0F;  ///< ...and this only motion
  static constexpr int kColorJump = 14;   ///< of 255; a colour that differs by more is another thing's
  static constexpr int kColorMotion = 5;  ///< of 255; likewise the mean of a block's differences
  static constexpr float kMovingShare = 0.4F;  ///< of the blocks that move when the camera does
  static constexpr int kGlance = 8;  ///< only every so many rows of blocks are looked at while it does

  /// Replaces depth, state and colour by what is kept. Depth that is shown beyond its measurement keeps its
  /// state. The first frame and one of another size begin anew. A frame without colour is filtered by its
  /// depth alone; the first with colour after it begins the colours anew and leaves the depth going on.
  void apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise);

 private:
  struct Block {
    float gain = 0;  // of new depth: 0 noise alone, 1 it replaces what is kept
    bool is_recolored = false;
    bool is_still = false;  // neither it nor a neighbour moves
    bool moves() const { return gain > 0.5F || is_recolored; }
  };
  struct Kept {
    std::vector<float> depth;  // in units; 0 where there is none
    std::vector<DepthState> state;
    std::vector<float> frames;         // in the mean, at most kFrames
    std::vector<std::uint8_t> missed;  // frames since the last that agreed
    std::vector<std::int16_t> color;   // r, g, b of each pixel, times 128
  };
  // Of a row of whole blocks, by column of pixels, or by byte of colour.
  struct Sums {
    std::vector<float> difference, agreeing, jumping;
    std::vector<std::int16_t> recolored;
  };
  // Of a row of blocks spread over their pixels.
  struct Spread {
    std::vector<float> gain;         // of new depth, at least
    std::vector<std::int16_t> jump;  // of colour, that replaces what is kept; by byte
  };

  bool fits(const RgbdFrame& frame) const;
  void begin(const RgbdFrame& frame);
  void begin_color(const ColorImage& color);
  /// Depth and colour of every `every`th row of blocks, to judge the next frame by.
  void keep_pictures(const RgbdFrame& frame, int every);
  /// Looks at every `every`th row of blocks; returns whether the camera moves.
  bool judge(const RgbdFrame& frame, int every);
  void sum_row(const RgbdFrame& frame, int y);
  Block judge_block(int left, int rows) const;
  void find_still();
  void spread(int block_row);
  void mix_depth(RgbdFrame& frame, int y);
  void decide(const RgbdFrame& frame, const Block& block, std::size_t at);
  void mix_color(ColorImage& color, int y);
  const Block& block_of(int x, int y) const {
    return blocks_[static_cast<std::size_t>(y / kBlock * columns_ + x / kBlock)];
  }

  int width_ = 0, height_ = 0, columns_ = 0;
  bool has_color_ = false;      // the last frame had
  bool camera_moves_ = false;   // so only the rows of blocks that are looked at are kept
  std::uint64_t sequence_ = 0;  // of the last frame
  int frames_since_ = 1;        // from the last frame to this one
  float step_per_square_ = 0;   // a sensor step at depth z is this times z^2, in units
  std::vector<Block> blocks_;
  Kept kept_;
  Sums sums_;
  Spread spread_;
  std::vector<std::uint8_t> changed_;  // of a row: 1 where pixels do not simply go on...
  std::vector<float> goes_on_;         // ...and 1 where they do
};

}  // namespace copresence::client
