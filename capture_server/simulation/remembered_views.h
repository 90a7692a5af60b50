#pragma once

// The views of one period of the figure's motion, each as what it has different from the still room: a second time
// nothing need be traced. About 0.5 MB a view of 640x480.
//
// Thread: one thread per object.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "capture_server/simulation/true_view.h"

namespace copresence::simulation {

class RememberedViews {
 public:
  explicit RememberedViews(std::size_t count) : views_(count) {}

  std::size_t count() const { return views_.size(); }
  bool knows(std::size_t index) const { return views_[index].known; }

  /// `still`: the same view without the figure, the same at every call.
  void remember(std::size_t index, const TrueView& view, const TrueView& still);

  /// The view as it was remembered; its own until the next call. Requires knows(index).
  const TrueView& show(std::size_t index, const TrueView& still);

 private:
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  struct Difference {
    bool known = false;
    std::vector<Run> surface_runs, color_runs;
    std::vector<float> depth_m, infrared;  // of the surface runs' pixels
    std::vector<Rgb8> color;
  };

  std::vector<Difference> views_;
  TrueView shown_;
  const Difference* last_ = nullptr;
};

}  // namespace copresence::simulation
