#include "capture_server/simulation/remembered_views.h"

#include <algorithm>
#include <cassert>

namespace copresence::simulation {
namespace {

// Runs of pixels for which `differs` holds; short gaps belong to a run, which costs less than another one.
template <class Runs, class Differs>
void find_runs(std::size_t pixels, Differs&& differs, Runs& runs) {
  constexpr std::uint32_t kGap = 8;
  for (std::uint32_t i = 0; i < pixels; ++i) {
    if (!differs(i)) continue;
    if (!runs.empty() && i - (runs.back().first + runs.back().count) < kGap) {
      runs.back().count = i + 1 - runs.back().first;
    } else {
      runs.push_back({i, 1});
    }
  }
}

template <class Runs, class Pixel>
void pick(const Runs& runs, const Image<Pixel>& image, std::vector<Pixel>& into) {
  for (const auto& run : runs)
    into.insert(into.end(), image.data() + run.first, image.data() + run.first + run.count);
}

template <class Runs, class Pixel>
void put(const Runs& runs, const std::vector<Pixel>& from, Image<Pixel>& image) {
  const Pixel* next = from.data();
  for (const auto& run : runs) {
    std::copy_n(next, run.count, image.data() + run.first);
    next += run.count;
  }
}

template <class Runs, class Pixel>
void put_back(const Runs& runs, const Image<Pixel>& from, Image<Pixel>& image) {
  for (const auto& run : runs) std::copy_n(from.data() + run.first, run.count, image.data() + run.first);
}

}  // namespace

void RememberedViews::remember(std::size_t index, const TrueView& view, const TrueView& still) {
  assert(same_shape(view.depth_m, still.depth_m));
  Difference& made = views_[index];
  if (last_ == &made) last_ = nullptr;
  made = {};
  const std::size_t pixels = view.depth_m.pixels().size();
  const auto surface_differs = [&](std::size_t i) {
    return view.depth_m.data()[i] != still.depth_m.data()[i] ||
           view.infrared.data()[i] != still.infrared.data()[i];
  };
  const auto color_differs = [&](std::size_t i) { return view.color.data()[i] != still.color.data()[i]; };
  find_runs(pixels, surface_differs, made.surface_runs);
  find_runs(pixels, color_differs, made.color_runs);
  pick(made.surface_runs, view.depth_m, made.depth_m);
  pick(made.surface_runs, view.infrared, made.infrared);
  pick(made.color_runs, view.color, made.color);
  made.known = true;
}

const TrueView& RememberedViews::show(std::size_t index, const TrueView& still) {
  assert(knows(index));
  if (!last_) {
    shown_ = still;
  } else {
    put_back(last_->surface_runs, still.depth_m, shown_.depth_m);
    put_back(last_->surface_runs, still.infrared, shown_.infrared);
    put_back(last_->color_runs, still.color, shown_.color);
  }
  const Difference& view = views_[index];
  put(view.surface_runs, view.depth_m, shown_.depth_m);
  put(view.surface_runs, view.infrared, shown_.infrared);
  put(view.color_runs, view.color, shown_.color);
  last_ = &view;
  return shown_;
}

}  // namespace copresence::simulation
