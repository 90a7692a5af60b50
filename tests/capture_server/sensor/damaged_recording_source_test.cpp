// Recordings with damaged payloads, which the check does not read: how they are played.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <random>

#include "tests/capture_server/sensor/recorded_source.h"

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using test::RecordingScene;
using testing::HasSubstr;

TEST_F(RecordingSource, PlaysOnOverDamagedPayloadsWithAllOthersExact) {
  const RecordingScene scene{.frames = 12};
  std::minstd_rand random(3);
  for (int run = 0; run < 5; ++run) {
    const std::string path = recording(scene);
    auto bytes = test::bytes_of(path);
    const auto frames = test::records_of(bytes, recording::RecordType::kNewData, test::kDepthNode);
    const std::size_t damaged = 1 + random() % 10;
    for (int i = 0; i < 10; ++i) {
      bytes[frames[damaged].payload_at + random() % frames[damaged].payload_bytes] =
          static_cast<std::uint8_t>(random());
    }
    test::write_bytes(path, bytes);
    const auto source = open(path, kFast);
    std::vector<DepthImage> played;
    while (true) {
      auto frame = source->next({});
      if (!frame) {
        EXPECT_EQ(frame.error().code, ErrorCode::kEndOfStream) << frame.error().what;
        break;
      }
      played.push_back(std::move(frame->depth));
    }
    // The damaged one is altered or missing; all others are there, in order.
    const bool missing = played.size() == 11;
    ASSERT_TRUE(missing || played.size() == 12u) << played.size();
    EXPECT_EQ(source->counters().damaged, missing ? 1u : 0u);
    for (std::size_t i = 0, at = 0; i < 12; ++i) {
      if (i == damaged) {
        at += !missing;
        continue;
      }
      EXPECT_EQ(played[at++], scene.depth_of(static_cast<int>(i))) << i;
    }
  }
}

TEST_F(RecordingSource, PlaysToTheEndOfARecordingWithFramesLeftOut) {
  const RecordingScene scene{.frames = 6, .color = std::nullopt};
  const std::string path = recording(scene);
  auto bytes = test::bytes_of(path);
  const auto left_out = test::records_of(bytes, recording::RecordType::kNewData, test::kDepthNode)[1];
  const std::size_t seek_position_at =
      test::records_of(bytes, recording::RecordType::kNodeAdded, test::kDepthNode)[0].payload_at - 8;
  test::set_number_at(
      bytes, seek_position_at,
      test::number_at<std::uint64_t>(bytes, seek_position_at) - (left_out.end() - left_out.at));
  bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(left_out.at),
              bytes.begin() + static_cast<std::ptrdiff_t>(left_out.end()));
  test::write_bytes(path, bytes);
  const auto source = open(path, kFast);
  EXPECT_EQ(source->description().frames, 5u);
  for (const int i : {0, 2, 3, 4, 5}) {
    const auto frame = source->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->depth, scene.depth_of(i));
  }
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
}

TEST_F(RecordingSource, EndsWhereTheLastFrameIsTheDamagedOne) {
  const std::string path = recording({.frames = 4, .color = std::nullopt});
  auto bytes = test::bytes_of(path);
  const auto last = test::records_of(bytes, recording::RecordType::kNewData, test::kDepthNode)[3];
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(last.payload_at), last.payload_bytes,
              std::uint8_t{0xff});
  test::write_bytes(path, bytes);
  const auto source = open(path, kFast);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(source->next({}));
  const auto end = source->next({});
  EXPECT_TRUE(end || end.error().code == ErrorCode::kEndOfStream);
}

/// What a payload may become: something that is no picture, or a picture with too few pixels.
enum class Garbage { kNoPicture, kHalfAPicture };

/// Damages the pictures of one stream from number `first` (from 0) to before `end`, and nothing else of the file.
void damage_pictures(const std::string& path, std::uint32_t node, Garbage garbage, std::size_t first = 0,
                     std::size_t end = SIZE_MAX) {
  auto bytes = test::bytes_of(path);
  const auto pictures = test::records_of(bytes, recording::RecordType::kNewData, node);
  for (std::size_t i = first; i < std::min(end, pictures.size()); ++i) {
    const auto payload = bytes.begin() + static_cast<std::ptrdiff_t>(pictures[i].payload_at);
    std::fill_n(payload, pictures[i].payload_bytes, std::uint8_t{0xe0});
    if (garbage == Garbage::kNoPicture) continue;
    // A table of one level, its index, and then nothing but empty runs.
    const std::uint8_t nothing[] = {1, 0, 32, 3, 0, 0};
    std::copy(std::begin(nothing), std::end(nothing), payload);
  }
  test::write_bytes(path, bytes);
}

/// Processor time of this process so far.
std::chrono::duration<double> worked() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

TEST_F(RecordingSource, PlaysToTheEndAndSaysSoWhenNoFrameAtAllDecodes) {
  for (const Garbage garbage : {Garbage::kNoPicture, Garbage::kHalfAPicture}) {
    const std::string path = recording({.frames = 3, .color = std::nullopt});
    damage_pictures(path, test::kDepthNode, garbage);
    const auto source = open(path, kFast);
    const auto notice = source->next({});
    ASSERT_FALSE(notice);
    EXPECT_EQ(notice.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(notice.error().what, HasSubstr("depth pictures from 1 on cannot be decoded"));
    EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
    EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
    EXPECT_EQ(source->counters().damaged, 3u);
    EXPECT_EQ(source->counters().frames, 0u);
  }
}

TEST_F(RecordingSource, KeepsItsPaceWhereNoFrameDecodes) {
  const std::string path = recording({.frames = 6, .period_us = 50'000});
  damage_pictures(path, test::kDepthNode, Garbage::kNoPicture);
  const auto source = open(path, kReal);
  const auto begin = steady_clock::now();
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kCorrupt);
  EXPECT_LT(steady_clock::now() - begin, milliseconds(250));  // known long before the recording's end
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  EXPECT_GE(steady_clock::now() - begin, milliseconds(295));
  EXPECT_EQ(source->counters().damaged, 6u);
}

TEST_F(RecordingSource, LoopsAtItsPaceAndWithoutSpinningWhereNoFrameDecodes) {
  for (const SourceSettings& settings : {kRealLoop, kFastLoop}) {
    for (const Garbage garbage : {Garbage::kNoPicture, Garbage::kHalfAPicture}) {
      const std::string path = recording({.frames = 6, .period_us = 25'000, .color = std::nullopt});
      damage_pictures(path, test::kDepthNode, garbage);
      const auto source = open(path, settings);
      EXPECT_EQ(source->next({}).error().code, ErrorCode::kCorrupt);
      const auto begin = steady_clock::now();
      const auto worked_before = worked();
      while (steady_clock::now() - begin < milliseconds(700)) {
        const auto called = steady_clock::now();
        EXPECT_EQ(source->next({}).error().code, ErrorCode::kCorrupt);
        EXPECT_LT(steady_clock::now() - called, milliseconds(1500));  // a sign of life for who waits
      }
      EXPECT_LT((worked() - worked_before).count(), 0.2);
      // Four passes and a half of six pictures.
      EXPECT_GE(source->counters().damaged, 24u);
      EXPECT_LE(source->counters().damaged, 60u);
    }
  }
}

TEST_F(RecordingSource, LoopsOverTheOneFrameThatDecodes) {
  for (const std::size_t whole : {0, 2, 5}) {
    const RecordingScene scene{.frames = 6, .color = std::nullopt};
    const std::string path = recording(scene);
    damage_pictures(path, test::kDepthNode, Garbage::kNoPicture, 0, whole);
    damage_pictures(path, test::kDepthNode, Garbage::kHalfAPicture, whole + 1);
    const auto source = open(path, kFastLoop);
    for (int pass = 0; pass < 4; ++pass) {
      const auto frame = source->next({});
      ASSERT_TRUE(frame) << whole << ", pass " << pass << ": " << frame.error().what;
      EXPECT_EQ(frame->depth, scene.depth_of(static_cast<int>(whole)));
    }
    EXPECT_GE(source->counters().damaged, 15u + whole);
  }
}

TEST_F(RecordingSource, PlaysDepthWhereNoColorDecodes) {
  for (const SourceSettings& settings : {kFast, kFastLoop}) {
    const RecordingScene scene{.color = recording::ColorCoding::kJpeg};
    const std::string path = recording(scene);
    damage_pictures(path, test::kColorNode, Garbage::kNoPicture);
    const auto source = open(path, settings);
    const int passes = settings.loop ? 4 : 1;
    for (int i = 0; i < passes * scene.frames; ++i) {
      const auto frame = source->next({});
      ASSERT_TRUE(frame) << frame.error().what;
      EXPECT_EQ(frame->depth, scene.depth_of(i % scene.frames));
      EXPECT_FALSE(frame->color);
    }
    if (!settings.loop) {
      EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
    }
    // All of the passes that were delivered, and of the next one what was read ahead.
    EXPECT_GE(source->counters().damaged, 12u * static_cast<unsigned>(passes));
    EXPECT_LE(source->counters().damaged, 12u * static_cast<unsigned>(passes) + (settings.loop ? 6u : 0u));
  }
}

TEST_F(RecordingSource, CountsColorThatNoDepthEverCameFor) {
  const std::string path = recording({.frames = 6});
  damage_pictures(path, test::kDepthNode, Garbage::kNoPicture);
  const auto source = open(path, kFast);
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(source->next({}).error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(source->counters().damaged, 6u);
}

}  // namespace
}  // namespace copresence::sensor
