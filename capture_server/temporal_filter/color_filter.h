#pragma once

// Removes the grain from the colours of static surfaces by averaging over time.
//
// Each sample becomes its mean over the last frames, as long as its block of 8 x 8 pixels is
// static. A block that changes more than the camera's noise explains shows the new frame at once.
// Two tests find such blocks: the mean of the differences, which slow changes of light move, and
// the mean of their magnitudes, which moving texture increases. The noise itself is learned, for
// each brightness, as the median over all blocks. A single sample that differs by far more than
// noise is replaced without its block. If most of the picture changes, the frame passes unchanged.
//
// Works on the planes that the video encoder takes: half as many samples as RGB has.
//
// Thread: one thread at a time per object. After the first frame, nothing allocates memory.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/frame/picture.h"

namespace copresence::temporal_filter {

class ColorFilter {
 public:
  static constexpr int kBlock = 8;   ///< pixels a side
  static constexpr int kFrames = 8;  ///< frames in a mean: a new frame has at least the weight 1 / kFrames
  /// A block moves if the mean magnitude of its differences is this many times the noise's.
  static constexpr float kMotion = 1.4F;
  /// Beside a moving block, a smaller difference is motion.
  static constexpr float kMotionBeside = 1.15F;
  /// A block changes slowly if the mean of its differences is this many times its standard deviation.
  static constexpr float kSlowChange = 4;
  /// A sample is replaced if its difference is this many times the noise's mean magnitude.
  static constexpr float kSampleJump = 6;
  static constexpr float kMostlyChanged = 0.4F;  ///< share of moving blocks at which a frame passes unchanged
  static constexpr float kLeastNoise = 0.25F;    ///< of 255; of the mean magnitude

  /// Replaces the samples by the filtered ones. The first frame passes unchanged, as do the first
  /// after a change of size and all frames while the camera moves. Requires kYuv420.
  void apply(Picture& picture, bool camera_moves);

 private:
  static constexpr int kPlanes = 3;
  static constexpr int kBrightnesses = 8;
  struct Block {
    int frames = 1;      // in the mean, at most kFrames
    bool moves = false;  // in this frame
    std::array<bool, kPlanes> is_above_noise{};
    float magnitude = 0;  // of the differences, times that of noise
  };
  struct Plane {
    int width = 0, height = 0, block = kBlock;  // block: samples a side
    std::vector<std::int16_t> mean;             // of each sample, times 128
    // Sums over a row of blocks, by column.
    std::vector<std::int16_t> difference, magnitude;
    // Of a row of blocks, for each column: weight of the new frame, and the replacing difference.
    std::vector<std::int16_t> weight, jump;
  };
  // Mean magnitudes of the differences between a frame and the mean of many.
  struct Noise {
    std::array<float, kPlanes> magnitude;
  };
  struct Difference {
    float mean = 0, magnitude = 0;
  };

  bool fits(const Picture& picture) const;
  void begin(const Picture& picture);
  void keep(const Picture& picture);
  bool find_motion(const Picture& picture);
  void sum_rows(const Picture& picture, int plane, int row);
  Difference difference(const Plane& plane, int column, int row) const;
  void judge(int column, int row);
  void learn_noise();
  void end_changes();
  void spread(int row);
  void mix_rows(Picture& picture, int plane, int row);
  int brightness_at(int column, int row) const;
  const Noise& noise_at(int column, int row) const;
  Block& block_at(int column, int row) { return blocks_[static_cast<std::size_t>(row * columns_ + column)]; }

  int columns_ = 0, rows_ = 0;
  std::array<Plane, kPlanes> planes_;
  std::vector<Block> blocks_;
  std::array<Noise, kBrightnesses> noise_{};
};

}  // namespace copresence::temporal_filter
