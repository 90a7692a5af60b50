#include "capture_server/hole_filling/median_filling.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "capture_server/hole_filling/filling_rules.h"

namespace copresence::hole_filling {
namespace {

constexpr int kMargin = kMedianWindowPx;
constexpr int kLanes = 16;  // Number of pixels in one vector register.
using Lanes = std::array<std::uint16_t, kLanes>;

/// Calls visit(pixels, is_rim) for every offset of the window, with the pixels at this offset.
/// `is_rim` is true on the window's rim.
template <class Visit>
void for_window(const std::uint16_t* middle, int stride, int radius, Visit visit) {
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      visit(middle + dy * stride + dx, std::max(std::abs(dx), std::abs(dy)) == radius);
    }
  }
}

}  // namespace

MedianFilling::MedianFilling(const FrameFormat& format)
    : width_(format.width),
      height_(format.height),
      steps_times_units_(steps_times_units(format.unit, format.noise)),
      range_(to_units(format.range, format.unit)),
      stride_(format.width + 2 * kMargin + kLanes),
      depths_(static_cast<std::size_t>(stride_) * (format.height + 2 * kMargin)) {}

const std::uint16_t* MedianFilling::padded(int x, int y) const {
  return depths_.data() + static_cast<std::size_t>(y + kMargin) * stride_ + x + kMargin;
}

void MedianFilling::load(const DepthImage& depth) {
  for (int y = 0; y < height_; ++y) {
    std::uint16_t* row = depths_.data() + static_cast<std::size_t>(y + kMargin) * stride_ + kMargin;
    std::copy(depth.row(y).begin(), depth.row(y).end(), row);
  }
}

Result<void> MedianFilling::fill(RgbdFrame& frame) {
  assert(frame.depth.width() == width_ && frame.depth.height() == height_ &&
         same_shape(frame.depth, frame.state));
  constexpr int kEdge = 2 * kMedianWindowPx + 1, kSmallEdge = 2 * kMedianSmallWindowPx + 1;
  load(frame.depth);
  pass({kMedianWindowPx, kEdge * kEdge * kMedianEnoughPercent / 100,
        4 * (kEdge - 1) * kMedianRimPercent / 100, kMedianSpread},
       frame);
  load(frame.depth);
  pass({kMedianSmallWindowPx, kSmallEdge * kSmallEdge / 2, 0, 65535}, frame);
  return {};
}

void MedianFilling::pass(const Window& window, RgbdFrame& frame) {
  for (int y = 0; y < height_; ++y) {
    const std::span<DepthState> states = frame.state.row(y);
    for (int first = 0; first < width_; first += kLanes) {
      const int lanes = std::min(kLanes, width_ - first);
      const auto is_measured = [](DepthState state) { return state == DepthState::kMeasured; };
      if (std::all_of(states.begin() + first, states.begin() + first + lanes, is_measured)) continue;

      const std::uint16_t* middle = padded(first, y);
      Lanes lowest, highest{}, count{}, rim{};
      lowest.fill(65535);
      for_window(middle, stride_, window.radius, [&](const std::uint16_t* depth, bool on_rim) {
        for (int i = 0; i < kLanes; ++i) {
          const std::uint16_t d = depth[i], holds = d != 0;
          lowest[i] = std::min(lowest[i], d == 0 ? std::uint16_t{65535} : d);
          highest[i] = std::max(highest[i], d);
          count[i] = static_cast<std::uint16_t>(count[i] + holds);
          rim[i] = static_cast<std::uint16_t>(rim[i] + (on_rim ? holds : 0));
        }
      });

      std::array<bool, kLanes> wanted{};
      int widest = 0;
      for (int i = 0; i < lanes; ++i) {
        wanted[i] = states[first + i] != DepthState::kMeasured && count[i] > 0 && count[i] >= window.enough &&
                    rim[i] >= window.enough_rim &&
                    steps_times_units_ / lowest[i] - steps_times_units_ / highest[i] <= window.widest;
        if (wanted[i]) widest = std::max(widest, highest[i] - lowest[i]);
      }
      if (std::none_of(wanted.begin(), wanted.end(), [](bool want) { return want; })) continue;

      // Binary search for the median from low + 1 to high: each count of pixels halves the range.
      Lanes low, high = highest;
      for (int i = 0; i < kLanes; ++i) low[i] = static_cast<std::uint16_t>(lowest[i] - 1);
      for (int range = widest + 1; range > 1; range -= range / 2) {
        Lanes half, below{};
        for (int i = 0; i < kLanes; ++i)
          half[i] = static_cast<std::uint16_t>(low[i] + (high[i] - low[i]) / 2);
        for_window(middle, stride_, window.radius, [&](const std::uint16_t* depth, bool) {
          for (int i = 0; i < kLanes; ++i) {
            below[i] =
                static_cast<std::uint16_t>(below[i] + (static_cast<std::uint16_t>(depth[i] - 1) < half[i]));
          }
        });
        for (int i = 0; i < kLanes; ++i) {
          const bool under = 2 * below[i] >= count[i];
          high[i] = under ? half[i] : high[i];
          low[i] = under ? low[i] : half[i];
        }
      }
      for (int i = 0; i < lanes; ++i) {
        if (!wanted[i] || !range_.contains(high[i])) continue;
        frame.depth(first + i, y) = high[i];
        states[first + i] = DepthState::kFilled;
      }
    }
  }
}

}  // namespace copresence::hole_filling
