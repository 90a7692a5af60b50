#pragma once

// Removes the noise of static surfaces by averaging over time. A Kinect's depth levels, hole rims
// and silhouette edges flicker, and its colours have grain. In a view from the side all of this
// looks like motion.
//
// Depth and colour of each pixel become their means over the last frames, as long as the pixel's
// block of 8 x 8 pixels is static. A surface that moves closer changes the mean depth of its block,
// which noise hardly does. A surface that moves sideways changes the colours. Moving blocks are
// shown as they come, without delay. In static blocks without moving neighbours, a pixel that loses
// its depth keeps it for some frames, and a single jump must be confirmed by a second frame. If
// much of the picture moves, the camera moves. Then nothing is filtered until two successive frames
// are alike again.
//
// Other filters also keep a depth value until a change lasts longer than noise would
// (librealsense's, for example). Deciding by block, and using colour to detect motion, is specific
// to this one. The constants are for the noise of a Kinect v1 (docs/internals/simulation.md).
//
// Thread: one thread at a time per object.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::decoding {

class TemporalFilter {
 public:
  static constexpr int kBlock = 8;   ///< pixels a side
  static constexpr int kFrames = 8;  ///< frames in a mean: a new frame has at least the weight 1 / kFrames
  static constexpr int kKeptFrames = 8;  ///< frames for which depth is kept without a measurement
  static constexpr float kJump = 3.5F;   ///< sensor steps; a greater difference means another surface
  static constexpr float kNoise = 0.5F;  ///< sensor steps; a smaller mean difference of a block is noise
  /// Sensor steps; a greater mean difference of a block is motion; in between the weight is linear.
  static constexpr float kMotion = 1.0F;
  static constexpr int kColorJump = 14;        ///< of 255; a greater difference means another surface
  static constexpr int kColorMotion = 5;       ///< of 255; a greater mean difference of a block is motion
  static constexpr float kMovingShare = 0.4F;  ///< fraction of moving blocks at which the camera moves
  /// While the camera moves, only every kGlance-th row of blocks is tested.
  static constexpr int kGlance = 8;

  /// Replaces depth, state and colour by the filtered ones. Depth that is kept without a
  /// measurement keeps its state. The filter starts again at the first frame and when the size
  /// changes. A frame without colour is filtered by its depth alone. The next frame with colour
  /// starts the colours again.
  void apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise);

 private:
  struct Block {
    float gain = 0;  // weight of new depth: 0 if only noise, 1 if it replaces the mean
    bool is_recolored = false;
    bool is_still = false;  // neither the block nor a neighbour moves
    bool moves() const { return gain > 0.5F || is_recolored; }
  };
  struct Kept {
    std::vector<float> depth;  // in units; 0 without depth
    std::vector<DepthState> state;
    std::vector<float> frames;         // number of frames in the mean, at most kFrames
    std::vector<std::uint8_t> missed;  // frames since the last one that agreed
    std::vector<std::int16_t> color;   // r, g, b of each pixel, times 128
  };
  // Sums over a row of blocks: per column of pixels, or per byte of a row of colours.
  struct Sums {
    std::vector<float> difference, agreeing, jumping;
    std::vector<std::int16_t> recolored;
  };
  // Results of a row of blocks, for each of their pixels.
  struct Spread {
    std::vector<float> gain;         // least weight of new depth
    std::vector<std::int16_t> jump;  // least difference at which new colour replaces the mean; by byte
  };

  bool fits(const RgbdFrame& frame) const;
  void begin(const RgbdFrame& frame);
  void begin_color(const ColorImage& color);
  /// Keeps depth and colour of every `every`-th row of blocks, to compare the next frame with.
  void keep_pictures(const RgbdFrame& frame, int every);
  /// Tests every `every`-th row of blocks. Returns whether the camera moves.
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
  bool has_color_ = false;      // the last frame had colour
  bool camera_moves_ = false;   // then only the tested rows of blocks are kept
  std::uint64_t sequence_ = 0;  // of the last frame
  int frames_since_ = 1;        // from the last frame to this one
  float step_per_square_ = 0;   // a sensor step at depth z is this times z^2, in units
  std::vector<Block> blocks_;
  Kept kept_;
  Sums sums_;
  Spread spread_;
  std::vector<std::uint8_t> changed_;  // of a row: 1 for pixels that jump or change their state
  std::vector<float> goes_on_;         // of a row: 1 for all other pixels
};

}  // namespace copresence::decoding
