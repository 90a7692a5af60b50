#pragma once

// What a camera has of the views of one period of the figure's motion, each as what differs from the still room: a second time
// nothing need be traced, nor found out what its projector and its colours make of it. About 0.6 MB a view of 640x480.
//
// Thread: one thread per object.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "simulation/sensed_view.h"

namespace copresence::simulation {

class RememberedViews {
 public:
  /// `still`: the view without the figure.
  RememberedViews(std::size_t count, SensedView still);

  std::size_t count() const { return views_.size(); }
  bool knows(std::size_t index) const { return views_[index].known; }

  /// Requires a view of the still one's size.
  void remember(std::size_t index, const SensedView& view);

  /// The view as it was remembered; its own until the next call. Requires knows(index).
  const SensedView& show(std::size_t index);

 private:
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  struct Difference {
    bool known = false;
    std::vector<Run> dot_runs, color_runs;
    std::vector<Dots> dots;  // of the runs' pixels
    std::vector<SensedColor> colors;
  };

  void change_to(const Difference* view);  // null: the still one

  std::vector<Difference> views_;
  const SensedView still_;
  SensedView shown_;
  const Difference* last_ = nullptr;  // what shown_ has different from the still view, if anything
};

}  // namespace copresence::simulation
