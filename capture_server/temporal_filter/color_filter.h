#pragma once

// Removes noise from the colours of static surfaces by averaging over time.
//
// Each sample becomes its mean over the last frames while its block of 8 x 8 pixels is static. A
// block that changes more than noise explains shows the new frame at once. Two tests find such
// blocks. The mean of the differences detects slow changes of light. The mean of their magnitudes
// detects moving texture. The filter learns the noise for each brightness: it is near the lower
// quartile of all blocks. A single sample that differs by far more than noise is replaced alone. If
// most of the picture changes, the frame passes unchanged.
//
// The filter works on the YUV planes of the video encoder, which have half as many samples as RGB.
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
  static constexpr int kBlock = 8;   ///< Width and height of a block, in pixels.
  static constexpr int kFrames = 8;  ///< A new frame's weight in a mean is at least 1 / kFrames.
  /// A block moves if the mean magnitude of its differences is this many times that of the noise.
  static constexpr float kMotion = 1.4F;
  /// Limit for blocks beside a moving block, in place of kMotion.
  static constexpr float kMotionBeside = 1.15F;
  /// A block changes slowly if the mean of its differences is this many standard deviations.
  static constexpr float kSlowChange = 4;
  /// A sample is replaced if its difference is this many times the mean magnitude of the noise.
  static constexpr float kSampleJump = 6;
  /// A frame passes unchanged if more than this share of its blocks moves.
  static constexpr float kMostlyChanged = 0.4F;
  static constexpr float kLeastNoise = 0.25F;  ///< Minimum mean magnitude of the noise, in 1/255.

  /// Replaces the samples by filtered ones. The first frame, the first frame of another size, and
  /// all frames while the camera moves pass unchanged. Requires kYuv420.
  void apply(Picture& picture, bool camera_moves);

 private:
  static constexpr int kPlanes = 3;
  static constexpr int kBrightnesses = 8;
  struct Block {
    int frames = 1;      // Number of earlier frames in the mean; 0 restarts the mean.
    bool moves = false;  // True if the block moves in the current frame.
    std::array<bool, kPlanes> is_above_noise{};
    float magnitude = 0;  // Mean magnitude of the differences, as a multiple of the noise.
  };
  struct Plane {
    int width = 0, height = 0, block = kBlock;  // In samples.
    std::vector<std::int16_t> mean;             // Mean of each sample, times 128.
    // Sums of the differences and of their magnitudes over a row of blocks, one per column.
    std::vector<std::int16_t> difference, magnitude;
    // Values for the columns of a row of blocks. `weight` is the weight of the new frame, times
    // 65536. A sample is replaced if its difference, times 128, is above `jump`.
    std::vector<std::int16_t> weight, jump;
  };
  // Mean magnitudes of the differences between a frame and the mean of many frames, by plane.
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
