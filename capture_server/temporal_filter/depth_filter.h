#pragma once

// Keeps the depth of static surfaces constant, so that a sensor's noise is neither coded nor shown.
//
// Each pixel holds one value that the sensor has measured. It takes a newer one when the mean of
// the last frames has moved away from it, or when the pixel shows another surface. Held values are
// the sensor's own levels, so a codec with a codebook needs no new ones. A pixel that flickers, for
// example between hole and depth, keeps the state that it has most of the time.
//
// Motion is never delayed. It is detected in blocks of 8 x 8 pixels, by two tests:
// - The mean depth of a block changes by more than noise could change it.
// - More pixels of a block than usual show another surface or lose their depth. Every pixel's rate
//   of such changes is learned, so that flickering edges do not count as motion.
// In moving blocks, pixels take new values at once. While the camera moves (camera_motion.h),
// frames pass unchanged.
//
// All thresholds are in steps of the sensor (DepthNoise). Holding values until a change exceeds the
// noise is a common method (librealsense's temporal filter, for example). The tests by block are
// specific to this filter.
//
// Thread: one thread at a time per object. After the first frame, nothing allocates memory.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "capture_server/temporal_filter/camera_motion.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::temporal_filter {

class DepthFilter {
 public:
  static constexpr int kBlock = 8;                   ///< pixels a side
  static constexpr float kMeanWeight = 1.0F / 8;     ///< of a new frame in a pixel's mean
  static constexpr float kHeldSteps = 0.7F;          ///< distance of the mean at which the value is replaced
  static constexpr float kNearMeanSteps = 0.5F;      ///< the new value is at most this far from the mean
  static constexpr float kOtherSurfaceSteps = 2.5F;  ///< a greater difference means another surface
  /// Change of a block's mean depth: below the first it is noise, above the second it is motion. In
  /// between, the weight of the new frame is linear.
  static constexpr float kNoiseSteps = 0.3F, kMotionSteps = 0.6F;
  static constexpr int kFewestPixels = 16;  ///< for a meaningful mean of a block
  /// Pixels of a block that must have changed beyond the usual number and kDeviations standard
  /// deviations: for motion in the block, and for motion that may extend into its neighbours.
  static constexpr float kDeviations = 1.5F;
  static constexpr float kMotionPixels = 10, kStrongMotionPixels = 24;
  /// Share of a block's pixels that have changed, above which the whole block shows something else.
  static constexpr float kReplaced = 0.75F;
  static constexpr int kFlickering = 40;  ///< of 255: rate of changes of a pixel that flickers
  static constexpr int kSteady = 16;      ///< of 255: rate below which a pixel is steady
  /// Number of frames that a change must last if nothing moves around it: a change of depth, the
  /// same for a pixel that flickers, and a change of the state.
  static constexpr int kConfirmingFrames = 2, kFlickeringDepthFrames = 4, kStateFrames = 12;
  static constexpr int kReach = 8;  ///< pixels; where to look for the surface behind one that has left

  DepthFilter(int width, int height, DepthUnit unit, const DepthNoise& noise);

  /// Replaces depth and state by the filtered ones. The first frame passes unchanged. Requires the
  /// size that the constructor was given.
  void apply(DepthImage& depth, StateImage& state);

  /// Whether the last frame passed unchanged, because the camera moves.
  bool is_camera_moving() const { return camera_.is_moving(); }

 private:
  struct Block {
    int differing = 0, jumping = 0, with_depth = 0;  // pixels; jumping: from one depth to another
    float usual = 0;                                 // expected value of `differing`
    float drift = 0;                                 // sum over the pixels that agree, in steps
    float weight = 0;                                // of the new frame in the pixels' means
    float excess = 0;                                // differing pixels that noise does not explain
    bool moves = false, is_near_motion = false, is_replaced = false;
  };
  // Sums over a row of blocks, by column of pixels.
  struct ColumnSums {
    std::vector<float> drift;
    std::vector<std::uint16_t> differing, jumping, flicker, with_depth;
  };

  void hold(std::size_t at, std::uint16_t depth, DepthState state);
  void hold_all(const DepthImage& depth, const StateImage& state);
  void compare(const DepthImage& depth, const StateImage& state);
  void compare_row(const DepthImage& depth, const StateImage& state, int y);
  void sum_blocks(int row);
  bool find_motion();
  void spread_motion();
  void filter_row(DepthImage& depth, StateImage& state, int y);
  void update_means(const std::uint16_t* depth, std::size_t at);
  bool differs_in_depth(std::uint16_t depth, std::size_t at) const;
  bool accepts(const Block& block, std::uint16_t depth, std::size_t at) const;
  std::uint16_t surface_behind(const DepthImage& depth, int x, int y) const;
  Block& block_at(int column, int row) { return blocks_[static_cast<std::size_t>(row * columns_ + column)]; }

  int width_, height_, columns_, rows_;
  float step_per_square_;  // a step at depth z is this times z^2, in units
  bool has_begun_ = false;
  CameraMotion camera_;

  // By pixel.
  std::vector<std::uint16_t> held_;
  std::vector<DepthState> held_state_;
  std::vector<std::uint16_t> same_surface_;  // largest difference to held_ of the same surface, in units
  std::vector<float> steps_per_unit_;        // 0 without depth
  std::vector<float> mean_;                  // of the difference to held_, in steps
  std::vector<std::uint8_t> differs_;        // 1: shows another surface, or another state, than held
  std::vector<std::uint8_t> flicker_;        // mean of differs_, times 255
  std::vector<std::uint8_t> doubts_;         // frames that spoke against the held value, less those for it

  std::vector<Block> blocks_;
  ColumnSums sums_;
  std::vector<std::uint16_t> other_surface_;              // of a row: 1 for pixels that show another surface
  std::vector<float> weight_;                             // of a row, by pixel: Block::weight
  std::vector<std::uint8_t> attention_;                   // of a row: 1 for pixels that need a decision
  std::vector<std::pair<int, std::uint16_t>> stand_ins_;  // of a row: columns, and the depth shown there
};

}  // namespace copresence::temporal_filter
