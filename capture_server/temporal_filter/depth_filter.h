#pragma once

// Keeps the depth of static surfaces constant, so that the sensor's noise is neither coded nor
// shown.
//
// Each pixel holds one measured value. It takes a newer value if the mean of the last frames has
// moved away from the held value, or if the pixel shows another surface. Held values are levels of
// the sensor, so a codec with a codebook needs no further levels. A pixel that flickers, for
// example between hole and depth, keeps the state that it has most of the time.
//
// Motion is never delayed. Two tests detect motion in blocks of 8 x 8 pixels. In the first test,
// the mean depth of a block changes by more than noise explains. In the second test, more pixels
// than usual show another surface or have another state. The filter learns each pixel's rate of
// such changes, so that flickering edges do not count as motion. In moving blocks, pixels take new
// values at once. While the camera moves (camera_motion.h), frames pass unchanged.
//
// All thresholds are in disparity steps of the sensor (DepthNoise). Other filters, such as the
// temporal filter of librealsense, also hold values until a change exceeds the noise. The tests of
// blocks are specific to this filter.
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
  static constexpr int kBlock = 8;                ///< Width and height of a block, in pixels.
  static constexpr float kMeanWeight = 1.0F / 8;  ///< Weight of a new frame in the mean of a pixel.
  /// A pixel takes a new value if its mean is farther than this from the held value, in steps. The
  /// new value must be within kNearMeanSteps of the mean.
  static constexpr float kHeldSteps = 0.7F;
  static constexpr float kNearMeanSteps = 0.5F;
  static constexpr float kOtherSurfaceSteps = 2.5F;  ///< Largest change on one surface.
  /// Limits for the change of the mean depth of a block, in steps. Below kNoiseSteps it is noise,
  /// above kMotionSteps motion. In between, the weight of the new frame is linear.
  static constexpr float kNoiseSteps = 0.3F, kMotionSteps = 0.6F;
  static constexpr int kFewestPixels = 16;  ///< A block's mean needs at least this many pixels.
  /// A block moves if more than kMotionPixels of its pixels have changed, beyond the expected
  /// number and kDeviations standard deviations. Above kStrongMotionPixels, its neighbours may
  /// move, too.
  static constexpr float kDeviations = 1.5F;
  static constexpr float kMotionPixels = 10, kStrongMotionPixels = 24;
  /// A block is replaced as a whole if more than this share of its pixels has changed.
  static constexpr float kReplaced = 0.75F;
  static constexpr int kFlickering = 40;  ///< Least change rate of a flickering pixel, in 1/255.
  static constexpr int kSteady = 16;      ///< Rate below which a pixel is steady, in 1/255.
  /// Number of frames that a change must last if nothing moves around it. For depth, the number is
  /// larger where a pixel flickers. A change of the state has its own number.
  static constexpr int kConfirmingFrames = 2, kFlickeringDepthFrames = 4, kStateFrames = 12;
  static constexpr int kReach = 8;  ///< Largest distance of a surface that fills a hole, in pixels.

  DepthFilter(int width, int height, DepthUnit unit, const DepthNoise& noise);

  /// Replaces depth and state by filtered ones. The first frame passes unchanged. Requires images
  /// of the constructor's size.
  void apply(DepthImage& depth, StateImage& state);

  /// Returns true if the last frame passed unchanged because the camera moves.
  bool is_camera_moving() const { return camera_.is_moving(); }

 private:
  struct Block {
    // Numbers of pixels. A jumping pixel changes from one depth to another.
    int differing = 0, jumping = 0, with_depth = 0;
    float usual = 0;   // Expected value of `differing`.
    float drift = 0;   // Sum of the differences of the agreeing pixels, in steps.
    float weight = 0;  // Weight of the new frame in the means.
    float excess = 0;  // Number of differing pixels that flicker does not explain.
    bool moves = false, is_near_motion = false, is_replaced = false;
  };
  // Sums over a row of blocks, one per column of pixels.
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
  float step_per_square_;  // A step at depth z is step_per_square_ * z^2, in units.
  bool has_begun_ = false;
  CameraMotion camera_;

  // One element per pixel.
  std::vector<std::uint16_t> held_;
  std::vector<DepthState> held_state_;
  std::vector<std::uint16_t> same_surface_;  // Largest difference within one surface, in units.
  std::vector<float> steps_per_unit_;        // Is 0 without depth.
  std::vector<float> mean_;                  // Mean difference to held_, in steps.
  std::vector<std::uint8_t> differs_;        // Is 1 if surface or state differ from the held ones.
  std::vector<std::uint8_t> flicker_;        // Mean of differs_, times 255.
  std::vector<std::uint8_t> doubts_;         // Number of differing frames minus agreeing frames.

  std::vector<Block> blocks_;
  ColumnSums sums_;
  // One element per pixel of a row.
  std::vector<std::uint16_t> other_surface_;  // Is 1 if the pixel shows another surface.
  std::vector<float> weight_;                 // Block::weight of the pixel's block.
  std::vector<std::uint8_t> attention_;       // Is 1 if the pixel may take a new value.
  // Columns of a row that show the depth behind a surface that has left, and that depth.
  std::vector<std::pair<int, std::uint16_t>> stand_ins_;
};

}  // namespace copresence::temporal_filter
