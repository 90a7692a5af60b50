#include "render_client/renderer/cpu/outlines.h"

#include <algorithm>

namespace copresence::renderer {
namespace {

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

void soften_outlines(const OutlineBits& outlines, int top, MergedView& view) {
  for (int row = 0; row < outlines.height(); ++row) {
    Rgba8* const pixels = view.color.row(top + row).data();
    const std::uint8_t* const groups = outlines.row(row).data();
    int changed_x = -1;  // the last pixel that was on the right of an outline, and its colour before
    Rgba8 changed{};
    for (int group = 0; group < outlines.width(); ++group) {
      unsigned here = groups[group];
      for (int at = group * kLanes; here != 0 && at + 1 < view.width; ++at, here >>= 1) {
        if (!(here & 1U)) continue;
        const Rgba8 left_before = at == changed_x ? changed : pixels[at];
        changed = pixels[at + 1];
        changed_x = at + 1;
        soften(pixels[at], pixels[at + 1], left_before);
      }
    }
  }
}

}  // namespace copresence::renderer
