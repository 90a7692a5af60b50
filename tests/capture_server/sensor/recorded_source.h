#pragma once

// A folder of recordings made for a test, and how they are opened.

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "capture_server/sensor/source.h"
#include "tests/support/recording_scene.h"

namespace copresence::sensor {

inline constexpr SourceSettings kFast{SourceSettings::Pace::kFast, false};
inline constexpr SourceSettings kFastLoop{SourceSettings::Pace::kFast, true};
inline constexpr SourceSettings kReal{SourceSettings::Pace::kReal, false};
inline constexpr SourceSettings kRealLoop{SourceSettings::Pace::kReal, true};

class RecordingSource : public testing::Test {
 protected:
  std::string recording(const test::RecordingScene& scene, const std::string& name = "x.oni") const {
    test::write_recording(folder_.file(name), scene);
    return folder_.file(name);
  }

  static std::unique_ptr<FrameSource> open(const std::string& path, const SourceSettings& settings) {
    auto source = open_source(path, settings);
    EXPECT_TRUE(source) << source.error().what;
    return source ? std::move(*source) : nullptr;
  }

  static void expect_states_match(const RgbdFrame& frame) {
    ASSERT_TRUE(same_shape(frame.depth, frame.state));
    for (std::size_t i = 0; i < frame.depth.pixels().size(); ++i) {
      ASSERT_EQ(frame.state.pixels()[i], frame.depth.pixels()[i] ? DepthState::kMeasured : DepthState::kHole);
    }
  }

  const test::TemporaryFolder folder_;
};

}  // namespace copresence::sensor
