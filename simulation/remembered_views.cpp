#include "simulation/remembered_views.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace copresence::simulation {
namespace {

// Runs of pixels that differ; short gaps belong to a run, which costs less than another one.
template <class Pixel, class Runs>
void find_runs(const Image<Pixel>& a, const Image<Pixel>& b, Runs& runs) {
  constexpr std::uint32_t kGap = 8;
  const Pixel* in_a = a.data();
  const Pixel* in_b = b.data();
  for (std::uint32_t i = 0; i < a.pixels().size(); ++i) {
    if (in_a[i] == in_b[i]) continue;
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

// From a picture that differs from `still` in the runs `before` to one that does in `after`, whose pixels are `pixels`. Most of the
// figure stays where it was for a frame: those pixels are written once.
template <class Runs, class Pixel>
void change(const Runs& before, const Runs& after, const std::vector<Pixel>& pixels,
            const Image<Pixel>& still, Image<Pixel>& shown) {
  auto covering = after.begin();
  for (const auto& run : before) {
    const std::uint32_t end = run.first + run.count;
    for (std::uint32_t first = run.first; first < end; first = covering->first + covering->count) {
      while (covering != after.end() && covering->first + covering->count <= first) ++covering;
      const std::uint32_t bare_end = covering == after.end() ? end : std::min(end, covering->first);
      if (first < bare_end) std::copy(still.data() + first, still.data() + bare_end, shown.data() + first);
      if (bare_end == end) break;
    }
  }
  const Pixel* next = pixels.data();
  for (const auto& run : after) {
    std::copy_n(next, run.count, shown.data() + run.first);
    next += run.count;
  }
}

}  // namespace

RememberedViews::RememberedViews(std::size_t count, SensedView still)
    : views_(count), still_(std::move(still)), shown_(still_) {}

void RememberedViews::remember(std::size_t index, const SensedView& view) {
  assert(same_shape(view.dots, still_.dots) && same_shape(view.colors, still_.colors));
  Difference& made = views_[index];
  if (last_ == &made) change_to(nullptr);
  made = {};
  find_runs(view.dots, still_.dots, made.dot_runs);
  find_runs(view.colors, still_.colors, made.color_runs);
  pick(made.dot_runs, view.dots, made.dots);
  pick(made.color_runs, view.colors, made.colors);
  made.known = true;
}

void RememberedViews::change_to(const Difference* view) {
  if (view == last_) return;
  static const Difference kNone;
  const Difference& before = last_ ? *last_ : kNone;
  const Difference& after = view ? *view : kNone;
  change(before.dot_runs, after.dot_runs, after.dots, still_.dots, shown_.dots);
  change(before.color_runs, after.color_runs, after.colors, still_.colors, shown_.colors);
  last_ = view;
}

const SensedView& RememberedViews::show(std::size_t index) {
  assert(knows(index));
  change_to(&views_[index]);
  return shown_;
}

}  // namespace copresence::simulation
