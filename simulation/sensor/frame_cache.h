#pragma once

// A cache of the noise-free frames of one period of the figure's motion. A live camera then only
// adds noise. Each frame is stored as its differences to the background: 0.6 MB at 640x480.
// Thread: one thread at a time per object.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "simulation/sensor/color_response.h"
#include "simulation/sensor/kinect_depth.h"

namespace copresence::simulation {

/// Dots and colours of a simulated Kinect before any noise is added.
struct NoiseFreeFrame {
  DotImage dots;
  NoiseFreeColors colors;
};

class FrameCache {
 public:
  /// Creates a cache for `count` frames. `background` is the frame without the figure.
  FrameCache(std::size_t count, NoiseFreeFrame background);

  std::size_t count() const { return frames_.size(); }
  bool contains(std::size_t index) const { return frames_[index].stored; }

  /// Stores or replaces a frame. Requires index < count() and the size of the background.
  void store(std::size_t index, const NoiseFreeFrame& frame);

  /// Returns the frame as it was stored, valid until the next call. Requires contains(index).
  const NoiseFreeFrame& load(std::size_t index);

 private:
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  struct Difference {
    bool stored = false;
    std::vector<Run> dot_runs, color_runs;
    std::vector<Dots> dots;  // Dots of the pixels in dot_runs.
    std::vector<NoiseFreeColor> colors;
  };

  void change_to(const Difference* frame);  // A null pointer stands for the background.

  std::vector<Difference> frames_;
  const NoiseFreeFrame background_;
  NoiseFreeFrame loaded_;
  const Difference* last_ = nullptr;  // Difference of loaded_ to the background, or null.
};

}  // namespace copresence::simulation
