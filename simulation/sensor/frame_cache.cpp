#include "simulation/sensor/frame_cache.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace copresence::simulation {
namespace {

// Finds runs of pixels that differ. Short gaps are made part of a run, which costs less.
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

// Changes `shown` from one frame to another. `before` and `after` are the runs in which the old and
// the new frame differ from `background`. `pixels` are the new frame's pixels in these runs. Most
// pixels are in runs of both frames. Such a pixel is written only once.
template <class Runs, class Pixel>
void change(const Runs& before, const Runs& after, const std::vector<Pixel>& pixels,
            const Image<Pixel>& background, Image<Pixel>& shown) {
  auto covering = after.begin();
  for (const auto& run : before) {
    const std::uint32_t end = run.first + run.count;
    for (std::uint32_t first = run.first; first < end; first = covering->first + covering->count) {
      while (covering != after.end() && covering->first + covering->count <= first) ++covering;
      const std::uint32_t uncovered_end = covering == after.end() ? end : std::min(end, covering->first);
      if (first < uncovered_end)
        std::copy(background.data() + first, background.data() + uncovered_end, shown.data() + first);
      if (uncovered_end == end) break;
    }
  }
  const Pixel* next = pixels.data();
  for (const auto& run : after) {
    std::copy_n(next, run.count, shown.data() + run.first);
    next += run.count;
  }
}

}  // namespace

FrameCache::FrameCache(std::size_t count, NoiseFreeFrame background)
    : frames_(count), background_(std::move(background)), loaded_(background_) {}

void FrameCache::store(std::size_t index, const NoiseFreeFrame& frame) {
  assert(same_shape(frame.dots, background_.dots) && same_shape(frame.colors, background_.colors));
  Difference& stored = frames_[index];
  if (last_ == &stored) change_to(nullptr);
  stored = {};
  find_runs(frame.dots, background_.dots, stored.dot_runs);
  find_runs(frame.colors, background_.colors, stored.color_runs);
  pick(stored.dot_runs, frame.dots, stored.dots);
  pick(stored.color_runs, frame.colors, stored.colors);
  stored.stored = true;
}

void FrameCache::change_to(const Difference* frame) {
  if (frame == last_) return;
  static const Difference kNone;
  const Difference& before = last_ ? *last_ : kNone;
  const Difference& after = frame ? *frame : kNone;
  change(before.dot_runs, after.dot_runs, after.dots, background_.dots, loaded_.dots);
  change(before.color_runs, after.color_runs, after.colors, background_.colors, loaded_.colors);
  last_ = frame;
}

const NoiseFreeFrame& FrameCache::load(std::size_t index) {
  assert(contains(index));
  change_to(&frames_[index]);
  return loaded_;
}

}  // namespace copresence::simulation
