#include "capture_server/simulation/remembered_views.h"

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

template <class Runs, class Pixel>
void put(const Runs& runs, const std::vector<Pixel>& from, Image<Pixel>& image) {
  const Pixel* next = from.data();
  for (const auto& run : runs) {
    std::copy_n(next, run.count, image.data() + run.first);
    next += run.count;
  }
}

template <class Runs, class Pixel>
void copy(const Runs& runs, const Image<Pixel>& from, Image<Pixel>& image) {
  for (const auto& run : runs) std::copy_n(from.data() + run.first, run.count, image.data() + run.first);
}

}  // namespace

RememberedViews::RememberedViews(std::size_t count, SensedView still)
    : views_(count), still_(std::move(still)), shown_(still_) {}

void RememberedViews::remember(std::size_t index, const SensedView& view) {
  assert(same_shape(view.dots, still_.dots) && same_shape(view.colors, still_.colors));
  put_back();
  Difference& made = views_[index];
  made = {};
  find_runs(view.dots, still_.dots, made.dot_runs);
  find_runs(view.colors, still_.colors, made.color_runs);
  pick(made.dot_runs, view.dots, made.dots);
  pick(made.color_runs, view.colors, made.colors);
  made.known = true;
}

void RememberedViews::put_back() {
  if (!last_) return;
  copy(last_->dot_runs, still_.dots, shown_.dots);
  copy(last_->color_runs, still_.colors, shown_.colors);
  last_ = nullptr;
}

const SensedView& RememberedViews::show(std::size_t index) {
  assert(knows(index));
  const Difference& view = views_[index];
  if (last_ == &view) return shown_;
  put_back();
  put(view.dot_runs, view.dots, shown_.dots);
  put(view.color_runs, view.colors, shown_.colors);
  last_ = &view;
  return shown_;
}

}  // namespace copresence::simulation
