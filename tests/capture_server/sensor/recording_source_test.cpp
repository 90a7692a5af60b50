// Recordings as frame sources, as capture_server opens them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <thread>

#include "tests/capture_server/sensor/recorded_source.h"
#include "tests/support/old_recording.h"
#include "tests/support/real_recordings.h"

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using test::RecordingScene;

TEST_F(RecordingSource, PlaysEveryFrameExactlyAndThenEnds) {
  const RecordingScene scene;
  const auto source = open(recording(scene), kFast);
  for (int i = 0; i < scene.frames; ++i) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->metadata.sequence, static_cast<std::uint64_t>(i + 1));
    EXPECT_EQ(frame->depth, scene.depth_of(i));
    expect_states_match(*frame);
    ASSERT_TRUE(frame->color);
    EXPECT_EQ(*frame->color, scene.color_of(i));
  }
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  const SourceCounters counters = source->counters();
  EXPECT_EQ(counters.frames, 12u);
  EXPECT_EQ(counters.depth_without_color + counters.color_without_depth + counters.damaged, 0u);
}

TEST_F(RecordingSource, KnowsTheSensorsLevelsWhereTheRecordingHasThem) {
  EXPECT_TRUE(open(recording({}), kFast)->description().levels.empty());
  const auto path = test::real_recording("arm_small.oni");
  if (!path) GTEST_SKIP() << "../shared/recordings/arm_small.oni is not here: its level table goes unread";
  const auto source = open(*path, kFast);
  const std::vector<std::uint16_t>& levels = source->description().levels;
  EXPECT_GT(levels.size(), 500u);
  EXPECT_TRUE(std::is_sorted(levels.begin(), levels.end(), std::less_equal<>()));
  for (auto frame = source->next({}); frame; frame = source->next({})) {
    for (const std::uint16_t z : frame->depth.pixels())
      ASSERT_TRUE(z == 0 || std::binary_search(levels.begin(), levels.end(), z)) << z;
  }
}

TEST_F(RecordingSource, LosesNoFrameInTwentyRuns) {
  const RecordingScene scene{.frames = 60};
  const std::string path = recording(scene);
  for (int run = 0; run < 20; ++run) {
    const auto source = open(path, kFast);
    for (int i = 0; i < scene.frames; ++i) {
      const auto frame = source->next({});
      ASSERT_TRUE(frame) << frame.error().what;
      ASSERT_EQ(frame->depth, scene.depth_of(i)) << "run " << run << " frame " << i;
      ASSERT_EQ(frame->color, scene.color_of(i)) << "run " << run << " frame " << i;
    }
    ASSERT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  }
}

TEST_F(RecordingSource, BeginsAgainWithoutAMissingOrADoubledFrame) {
  const RecordingScene scene{.frames = 7};
  const auto source = open(recording(scene), kFastLoop);
  for (int i = 0; i < 5 * scene.frames + 3; ++i) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    ASSERT_EQ(frame->metadata.sequence, static_cast<std::uint64_t>(i + 1));
    ASSERT_EQ(frame->depth, scene.depth_of(i % scene.frames)) << i;
    ASSERT_EQ(frame->color, scene.color_of(i % scene.frames)) << i;
  }
  EXPECT_EQ(source->counters().damaged, 0u);
  EXPECT_EQ(source->counters().depth_without_color, 0u);
}

TEST_F(RecordingSource, LoopsARecordingOfOneFrame) {
  const RecordingScene scene{.frames = 1, .color = std::nullopt};
  const auto source = open(recording(scene), kFastLoop);
  for (int i = 0; i < 5; ++i) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->depth, scene.depth_of(0));
  }
}

TEST_F(RecordingSource, KeepsTheRecordingsPaceOverTheSeam) {
  const RecordingScene scene{.frames = 6, .period_us = 20'000};
  const auto source = open(recording(scene), kRealLoop);
  std::vector<Instant> captured;
  for (int i = 0; i < 20; ++i) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    captured.push_back(frame->metadata.captured_at);
    EXPECT_LE(frame->metadata.captured_at, steady_clock::now());
  }
  // No single distance is tested: this machine may be busy. The sum shows a frame or a pause too many at the
  // seams.
  const double seconds = std::chrono::duration<double>(captured.back() - captured.front()).count();
  EXPECT_NEAR(seconds, 19 * 0.020, 0.018);
}

TEST_F(RecordingSource, PlaysDepthAlone) {
  const RecordingScene scene{.color = std::nullopt, .unit = DepthUnit::k100Micrometres};
  const auto source = open(recording(scene), kFast);
  EXPECT_FALSE(source->description().has_color);
  EXPECT_EQ(source->description().unit, DepthUnit::k100Micrometres);
  for (int i = 0; i < scene.frames; ++i) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->depth, scene.depth_of(i));
    EXPECT_FALSE(frame->color);
  }
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(source->counters().depth_without_color, 0u);
}

TEST_F(RecordingSource, PairsColorThatLeadsOrLagsByLessThanHalfAPeriod) {
  for (const RecordingScene& scene : {RecordingScene{.color_after_us = -12'000, .color_first = true},
                                      RecordingScene{.color_after_us = 15'000},
                                      RecordingScene{.color_after_us = -12'000, .color_first = false}}) {
    const auto source = open(recording(scene), kFast);
    for (int i = 0; i < scene.frames; ++i) {
      const auto frame = source->next({});
      ASSERT_TRUE(frame) << frame.error().what;
      ASSERT_EQ(frame->depth, scene.depth_of(i));
      ASSERT_EQ(frame->color, scene.color_of(i)) << i << " " << scene.color_after_us;
    }
  }
}

TEST_F(RecordingSource, ShowsANeighboursColorWhereOneIsMissing) {
  const RecordingScene scene{.without_color = {3, 4, 11}};
  const auto source = open(recording(scene), kFast);
  for (int i = 0; i < scene.frames; ++i) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->depth, scene.depth_of(i));
    EXPECT_TRUE(frame->color) << i;
  }
  EXPECT_EQ(source->counters().depth_without_color, 3u);
}

TEST_F(RecordingSource, TellsWhatTheRecordingsNoteTells) {
  const auto source = open(recording({.width = 70, .height = 50}), kFast);
  const SensorDescription& description = source->description();
  EXPECT_EQ(description.name, "one");
  EXPECT_EQ(description.depth.width, 70);
  EXPECT_EQ(description.depth.cx, 34.5);
  EXPECT_TRUE(description.registered);
  EXPECT_TRUE(description.is_recording);
  EXPECT_EQ(description.frames, 12u);
  EXPECT_NEAR(description.frames_per_second, 30, 0.01);
  EXPECT_FALSE(description.world_from_camera);
  EXPECT_TRUE(source->next({}));
}

TEST_F(RecordingSource, TakesLongPathsAndUnicode) {
  const RecordingScene scene{.frames = 2};
  std::string folder = folder_.file("K\xc3\xa4mmerchen");
  for (int i = 0; i < 4; ++i) folder += "/" + std::string(100, 'x');
  std::filesystem::create_directories(folder);
  std::filesystem::rename(recording(scene), folder + "/\xe6\xb7\xb1\xe5\xba\xa6.oni");
  const auto source = open(folder + "/\xe6\xb7\xb1\xe5\xba\xa6.oni", kFast);
  EXPECT_TRUE(source->next({}));
  EXPECT_TRUE(source->next({}));
}

TEST_F(RecordingSource, StopsWaitingWhenAskedTo) {
  const auto source = open(recording({.frames = 3, .period_us = 900'000}), kReal);
  ASSERT_TRUE(source->next({}));
  std::jthread asker;
  std::stop_source stop;
  asker = std::jthread([&] {
    std::this_thread::sleep_for(milliseconds(50));
    stop.request_stop();
  });
  const auto begin = steady_clock::now();
  EXPECT_EQ(source->next(stop.get_token()).error().code, ErrorCode::kEndOfStream);
  EXPECT_LT(steady_clock::now() - begin, milliseconds(500));
}

TEST_F(RecordingSource, RefusesWhatIsNotThereOrNoRecording) {
  EXPECT_EQ(open_source(folder_.file("missing.oni"), kFast).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(open_source(folder_.file(""), kFast).error().code, ErrorCode::kNotFound);
  test::write_bytes(folder_.file("empty.oni"), {});
  EXPECT_EQ(open_source(folder_.file("empty.oni"), kFast).error().code, ErrorCode::kCorrupt);
}

TEST_F(RecordingSource, PlaysRecordingsOfOpenNi1) {
  const RecordingScene scene{.frames = 5};
  const auto today = test::bytes_of(recording(scene));
  for (const std::uint32_t build : {4u, 5u, 6u}) {
    test::write_bytes(folder_.file("old.oni"), test::as_old_version(today, build));
    const auto source = open(folder_.file("old.oni"), kFast);
    ASSERT_TRUE(source) << build;
    for (int i = 0; i < scene.frames; ++i) {
      const auto frame = source->next({});
      ASSERT_TRUE(frame) << build << ": " << frame.error().what;
      EXPECT_EQ(frame->depth, scene.depth_of(i));
      EXPECT_EQ(*frame->color, scene.color_of(i));
    }
    EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  }
}

TEST_F(RecordingSource, PlaysTimesThatStandStillAtTheNominalRate) {
  const auto source = open(recording({.frames = 6, .period_us = 0, .color_after_us = 0}), kRealLoop);
  EXPECT_NEAR(source->description().frames_per_second, 30, 0.01);
  ASSERT_TRUE(source->next({}));
  const auto begin = steady_clock::now();
  for (int i = 0; i < 15; ++i) ASSERT_TRUE(source->next({})) << i;  // twice over the seam
  EXPECT_GT(steady_clock::now() - begin, milliseconds(15 * 33 - 50));
}

TEST_F(RecordingSource, NamesTheFileAndTheMendWhereFramesAreTooFarApart) {
  const auto refused = open_source(recording({.frames = 3, .period_us = 20'000'000}), kReal);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("x.oni"), std::string::npos);
  EXPECT_NE(refused.error().what.find("--times"), std::string::npos);
}

// Half a second of depth whose first frame was taken `late_ms` after the session's first instant.
std::string recording_of_a_session(const std::string& path, int late_ms) {
  recording::OniContent content;
  content.camera.model = {64, 48, 58, 58, 32, 24, {}};
  content.color.reset();
  content.unix_zero_us = 1'650'000'000'000'000 + 1000 * late_ms;
  auto writer = recording::OniWriter::create(path, content);
  EXPECT_TRUE(writer);
  for (int i = 0; i < 30; ++i) {
    const auto session_ms = static_cast<std::uint16_t>(late_ms + 50 * i);
    EXPECT_TRUE(writer->write_depth(milliseconds(50 * i), DepthImage(64, 48, session_ms)));
  }
  EXPECT_TRUE(writer->finish());
  return path;
}

TEST_F(RecordingSource, ShowsTheInstantThatOtherReplaysOfItsSessionShow) {
  ::setenv("XDG_RUNTIME_DIR", folder_.file("").c_str(), 1);
  for (const SourceSettings& settings : {kReal, kRealLoop}) {
    const auto early = open(recording_of_a_session(folder_.file(settings.loop ? "a" : "b"), 1), settings);
    // When the session's first instant was due on this process's clock, by frames and what they show. A frame that is read
    // late puts it too late, so the earliest counts.
    const auto zero_by = [](const std::unique_ptr<FrameSource>& source) {
      Instant zero = Instant::max();
      for (int i = 0; i < 5; ++i) {
        const auto frame = source->next({});
        EXPECT_TRUE(frame) << frame.error().what;
        if (frame)
          zero = std::min<Instant>(zero, frame->metadata.captured_at - milliseconds(frame->depth(5, 5)));
      }
      return zero;
    };
    const Instant zero_of_early = zero_by(early);
    // This replay is started later, and its recording was, too.
    const auto late = open(recording_of_a_session(folder_.file(settings.loop ? "c" : "d"), 301), settings);
    const auto apart = std::chrono::duration<double, std::milli>(zero_by(late) - zero_of_early);
    EXPECT_LT(std::abs(apart.count()), 40);
  }
}

TEST_F(RecordingSource, PlaysRealRecordings) {
  const std::pair<const char*, int> recordings[] = {
      {"arm_small.oni", 12}, {"office_view_a.oni", 15}, {"person.oni", 240}};
  for (const auto& [name, frames] : recordings) {
    const auto path = test::real_recording(name);
    if (!path) GTEST_SKIP() << "SKIPPED: no real recordings on this machine (COPRESENCE_RECORDINGS)";
    const auto source = open(*path, kFast);
    EXPECT_EQ(source->description().frames, static_cast<std::uint64_t>(frames));
    for (int i = 0; i < frames; ++i) ASSERT_TRUE(source->next({})) << name << " " << i;
    EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
    EXPECT_EQ(source->counters().depth_without_color + source->counters().damaged, 0u);
  }
}

}  // namespace
}  // namespace copresence::sensor
