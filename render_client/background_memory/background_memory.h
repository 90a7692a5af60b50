#pragma once

// Remembers the surfaces that a still camera saw earlier and that something hides now.
//
// Every pixel keeps depth and colour of the farthest surface that it has seen steadily. Where
// something nearer covers that surface, or where the newest frame has a hole, the surface is drawn
// behind everything that is seen (renderer/merge_rules.h, Remembered). So the wall behind a person
// stays visible from the side once the person has moved.
//
// A surface is remembered after kSteadyFrames frames that agree on it. It is replaced once
// kSteadyFrames frames agree on a farther surface. Its colour is taken only at some distance from
// the covering object, since depth and colour disagree along silhouettes. If the camera moves,
// everything is forgotten.
//
// Thread: one thread at a time.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::background_memory {

/// At 30 frames per second, a third of a second.
inline constexpr int kSteadyFrames = 10;

class BackgroundMemory {
 public:
  /// Forgets everything, and takes frames with depth in `unit` from now on.
  void begin(DepthUnit unit, const DepthNoise& noise);

  /// Learns from the camera's next frame. Requires begin() and images of one shape; another shape
  /// or pose than before forgets everything.
  void learn(const RgbdFrame& frame);

  /// Returns the remembered surfaces that the last frame does not show, and some pixels around
  /// them. Depth is 0 elsewhere. The frame stays the same object until covered surfaces come or go,
  /// so a mesh made of it can be kept. Null if nothing is covered.
  std::shared_ptr<const RgbdFrame> covered() const { return covered_; }

 private:
  /// The largest difference between two measurements of one surface, proportional to the square of
  /// the depth. The computation uses integers, so that the loop over all pixels can be vectorised.
  class Tolerance {
   public:
    Tolerance() = default;
    explicit Tolerance(double per_square);
    int operator()(int depth) const {
      const int coarse = std::min(depth >> kCoarse, most_);
      return ((coarse * coarse * per_square_) >> kFraction) + 1;
    }

   private:
    static constexpr int kCoarse = 4, kFraction = 16;  // Numbers of bits.
    int per_square_ = 0, most_ = 0;
  };

  /// The result of comparing a part of the newest frame with the remembered surfaces.
  struct Comparison {
    std::uint32_t known = 0;      ///< Number of pixels with a remembered surface and a depth.
    std::uint32_t agree = 0;      ///< Number of the known pixels that show the remembered surface.
    std::uint32_t farther = 0;    ///< Number of the known pixels that show something farther.
    std::uint32_t colored = 0;    ///< Number of pixels whose colours were compared.
    std::uint32_t recolored = 0;  ///< Number of the compared pixels whose colour has changed.
  };

  void forget(int width, int height);
  void learn_depth(const RgbdFrame& frame, int y);
  void count_flags(int y, Comparison* regions);
  void learn_colors(const RgbdFrame& frame, int y, Comparison& all);
  static bool camera_has_moved(std::span<const Comparison> regions, const Comparison& colors);
  void draw_covered(const RgbdFrame& newest);

  DepthUnit unit_ = DepthUnit::kMillimetre;
  Tolerance tolerance_;
  bool has_color_ = false;
  Rigid3 pose_;  // The last frame's pose in the world.
  std::uint64_t frames_ = 0;
  std::uint64_t resumes_at_ = 0;     // Frames before this number are not learned from.
  DepthImage depth_;                 // The remembered surface; 0 where there is none.
  DepthImage candidate_;             // A farther surface that may replace it; 0 where there is none.
  Image<std::uint16_t> times_seen_;  // Number of frames in a row that agree on the candidate.
  ColorImage color_;
  Image<std::uint8_t> color_quality_;
  std::vector<std::uint8_t> flags_;  // Flags of one row of pixels, padded with zeros to whole blocks.
  // One element per block of kBlock x kBlock pixels.
  Image<std::uint8_t> covered_pixels_;  // Whether something covers the remembered surface.
  Image<std::uint8_t> refuted_pixels_;  // Whether something farther than that surface is seen.
  Image<std::uint8_t> near_covered_;    // Whether the block or a neighbour is covered.
  Image<std::uint8_t> drawn_;           // Whether `covered_` shows the block.
  std::uint64_t drawn_at_ = 0;          // The value of frames_ when `covered_` was drawn.
  std::shared_ptr<const RgbdFrame> covered_;
};

}  // namespace copresence::background_memory
