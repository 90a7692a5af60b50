// How well the fillers guess real depth: pixels that a Kinect measured, hidden under the holes of the frame 45 later.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/sensor/source.h"
#include "tests/support/real_recordings.h"

namespace copresence::hole_filling {
namespace {

constexpr std::size_t kLater = 45, kEvery = 15;  // frames
constexpr double kStepsMm = 351300;

std::vector<RgbdFrame> frames_of(const std::string& path) {
  const auto source = sensor::open_source(path, {sensor::SourceSettings::Pace::kFast, false});
  EXPECT_TRUE(source) << source.error().what;
  std::vector<RgbdFrame> frames;
  if (!source) return frames;
  for (auto frame = (*source)->next({}); frame; frame = (*source)->next({})) {
    for (std::size_t i = 0; i < frame->depth.pixels().size(); ++i) {
      if (frame->depth.data()[i] >= 400 && frame->depth.data()[i] <= 5000) continue;
      frame->depth.data()[i] = 0;
      frame->state.data()[i] = DepthState::kHole;
    }
    frames.push_back(std::move(*frame));
  }
  return frames;
}

struct Quality {
  double filled_percent, median_steps, p90_steps;
};

Quality judge(Method method, const std::vector<RgbdFrame>& frames) {
  const auto filler = open(method, Compute::kCpu, {}).value();
  std::vector<double> errors;
  std::size_t hidden = 0;
  for (std::size_t i = 0; i + kLater < frames.size(); i += kEvery) {
    RgbdFrame frame = frames[i];
    for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p) {
      if (frames[i + kLater].state.data()[p] != DepthState::kHole) continue;
      frame.depth.data()[p] = 0;
      frame.state.data()[p] = DepthState::kHole;
    }
    EXPECT_TRUE(filler->fill(frame));
    for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p) {
      const double truth = frames[i].depth.data()[p];
      if (truth == 0 || frames[i + kLater].state.data()[p] != DepthState::kHole) continue;
      ++hidden;
      if (frame.state.data()[p] != DepthState::kFilled) continue;
      errors.push_back(std::abs(kStepsMm / frame.depth.data()[p] - kStepsMm / truth));
    }
  }
  EXPECT_GT(errors.size(), 10'000u);
  std::sort(errors.begin(), errors.end());
  return {100 * static_cast<double>(errors.size()) / static_cast<double>(hidden), errors[errors.size() / 2],
          errors[errors.size() * 9 / 10]};
}

class HiddenDepth : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Recordings, HiddenDepth, testing::Values("office", "desk"),
                         [](const auto& param) { return std::string(param.param); });

TEST_P(HiddenDepth, IsGuessedByTheJointFillerWithinThreeSteps) {
  const auto path = test::real_recording(std::string(GetParam()) + ".oni");
  if (!path)
    GTEST_SKIP() << "../shared/recordings/" << GetParam() << ".oni is not here: real holes go unmeasured";
  const std::vector<RgbdFrame> frames = frames_of(*path);
  for (const Method method : {Method::kJoint, Method::kBilateral, Method::kMedian}) {
    const Quality quality = judge(method, frames);
    std::printf("%-7s %-9s filled %5.1f %%, median error %.2f steps, 90th percentile %.2f\n", GetParam(),
                std::string(name(method)).c_str(), quality.filled_percent, quality.median_steps,
                quality.p90_steps);
    if (method == Method::kJoint) {
      EXPECT_LT(quality.median_steps, 3);
    }
  }
}

}  // namespace
}  // namespace copresence::hole_filling
