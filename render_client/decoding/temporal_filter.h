#pragma once

// Removes the noise of static surfaces by averaging over time. A Kinect's depth levels, hole rims
// and silhouette edges flicker, and its colours have grain. In other views this looks like motion.
//
// While a block of 8 x 8 pixels is static, each pixel shows its mean depth and colour over the last
// frames. A surface that moves closer changes the mean depth of its block; noise hardly does. A
// surface that moves sideways changes the colours. Moving blocks are not filtered.
//
// In static blocks without moving neighbours, a pixel that loses its depth keeps the old depth for
// kKeptFrames frames. A jump of its depth must be confirmed by a second frame.
//
// If much of the picture moves, the camera itself is assumed to move. Then nothing is filtered
// until two successive frames are alike again.
//
// The filter of librealsense also keeps a depth value until a change lasts longer than noise would.
// Unlike that filter, this one decides for whole blocks and uses colour to detect motion. The
// constants suit the noise of a Kinect v1 (docs/internals/simulation.md). Thread: one thread at a
// time.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::decoding {

class TemporalFilter {
 public:
  static constexpr int kBlock = 8;  ///< Width and height of a block in pixels.
  /// A mean covers this many frames: a new frame has at least the weight 1 / kFrames.
  static constexpr int kFrames = 8;
  /// Depth is kept without a new measurement for this many frames.
  static constexpr int kKeptFrames = 8;
  /// A pixel whose depth changes by more than this many sensor steps shows another surface.
  static constexpr float kJump = 3.5F;
  /// A mean difference of a block up to kNoise sensor steps is noise, and from kMotion steps on it
  /// is motion. In between, the weight of the new depth grows linearly.
  static constexpr float kNoise = 0.5F;
  static constexpr float kMotion = 1.0F;
  /// A pixel whose colour changes by more than this, of 255, shows another surface.
  static constexpr int kColorJump = 14;
  /// A greater mean change of a block's colours, of 255, is motion.
  static constexpr int kColorMotion = 5;
  /// If more than this fraction of all blocks moves, the camera moves.
  static constexpr float kMovingShare = 0.4F;
  /// While the camera moves, only every kGlance-th row of blocks is tested.
  static constexpr int kGlance = 8;

  /// Replaces depth, state and colour by the filtered values. Depth that is kept without a
  /// measurement keeps its state. The first frame and every change of size reset the filter. A
  /// frame without colour is filtered by its depth alone.
  void apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise);

 private:
  struct Block {
    float gain = 0;  // Weight of new depth: 0 for noise, 1 for motion.
    bool is_recolored = false;
    bool is_still = false;  // Neither the block nor a neighbouring block moves.
    bool moves() const { return gain > 0.5F || is_recolored; }
  };
  struct Kept {
    std::vector<float> depth;  // Depth in depth units; 0 for a hole.
    std::vector<DepthState> state;
    std::vector<float> frames;         // Number of frames in the mean, at most kFrames.
    std::vector<std::uint8_t> missed;  // Number of frames since a frame agreed with the mean.
    std::vector<std::int16_t> color;   // Red, green and blue of each pixel, times 128.
  };
  // Sums over the pixels of a column within a row of blocks. `recolored` has one sum per channel.
  struct Sums {
    std::vector<float> difference, agreeing, jumping;
    std::vector<std::int16_t> recolored;
  };
  // The results of a row of blocks, repeated for each column of pixels.
  struct Spread {
    std::vector<float> gain;  // Minimum weight of new depth.
    // A greater difference of a colour channel replaces the mean. One value per channel.
    std::vector<std::int16_t> jump;
  };

  bool fits(const RgbdFrame& frame) const;
  void begin(const RgbdFrame& frame);
  void begin_color(const ColorImage& color);
  /// Stores depth and colour of every `every`-th row of blocks for comparison with the next frame.
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
  bool has_color_ = false;      // Whether the last frame had colour.
  bool camera_moves_ = false;   // While it is true, only the tested rows of blocks are kept.
  std::uint64_t sequence_ = 0;  // Number of the last frame.
  int frames_since_ = 1;        // Number of frames captured since the last received frame.
  float step_per_square_ = 0;   // A sensor step at depth z is this times z^2, in depth units.
  std::vector<Block> blocks_;
  Kept kept_;
  Sums sums_;
  Spread spread_;
  std::vector<std::uint8_t> changed_;  // Holds 1 for pixels that jump or change their state.
  std::vector<float> goes_on_;         // Holds 1 for all other pixels.
};

}  // namespace copresence::decoding
