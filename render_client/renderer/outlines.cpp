#include "render_client/renderer/outlines.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

// The nearest fragments at eight pixels from x on.
Floats nearest(std::span<const Band> bands, int x, int y) {
  Floats w = load<Floats>(bands[0].depths(y) + x);
  for (std::size_t i = 1; i < bands.size(); ++i) w = larger(w, load<Floats>(bands[i].depths(y) + x));
  return w;
}

// Both sides of an outline, as they were before.
void soften(Rgba8& left, Rgba8& right, const Rgba8& left_before) {
  const Rgba8 right_before = right;
  const auto mix = [](std::uint8_t& own, std::uint8_t from, std::uint8_t other) {
    own = static_cast<std::uint8_t>(std::clamp(own + (other - from) / kOutlineDivisor, 0, 255));
  };
  for (const auto channel : {&Rgba8::r, &Rgba8::g, &Rgba8::b}) {
    mix(left.*channel, left_before.*channel, right_before.*channel);
    mix(right.*channel, right_before.*channel, left_before.*channel);
  }
}

}  // namespace

void soften_outlines(std::span<const Band> bands, MergedView& view) {
  assert(!bands.empty());
  constexpr float kApart = kOutlineSteps * kStepInverse;
  const float empty = bands[0].empty();
  for (int y = bands[0].top(); y < bands[0].top() + bands[0].rows(); ++y) {
    Rgba8* const pixels = view.color.row(y).data();
    int changed_x = -1;  // the last pixel that was on the right of an outline, and its colour before
    Rgba8 changed{};
    for (int x = 0; x + 1 < view.width; x += kLanes) {
      const Floats here = nearest(bands, x, y), next = nearest(bands, x + 1, y);
      const Floats difference = here - next;
      unsigned outlines =
          bits(((difference > kApart) | (difference < -kApart)) & (here > empty) & (next > empty));
      for (int at = x; outlines != 0 && at + 1 < view.width; ++at, outlines >>= 1) {
        if (!(outlines & 1U)) continue;
        const Rgba8 left_before = at == changed_x ? changed : pixels[at];
        changed = pixels[at + 1];
        changed_x = at + 1;
        soften(pixels[at], pixels[at + 1], left_before);
      }
    }
  }
}

}  // namespace copresence::renderer
