#include "capture_server/recording/oni_repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_reader.h"
#include "tests/support/old_recording.h"
#include "tests/support/real_recordings.h"
#include "tests/support/recording_scene.h"

namespace copresence::recording {
namespace {

using std::chrono::microseconds;
using test::bytes_of;
using test::kColorNode;
using test::kDepthNode;
using test::records_of;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;
using Kind = RecordedStream::Kind;

const ProgressReport kNobodyWatches = [](double) {};

class OniRepair : public testing::Test {
 protected:
  std::string file(const char* name) const { return folder_.file(name); }

  Bytes write(const char* name, const test::RecordingScene& scene = {}) const {
    test::write_recording(file(name), scene);
    return bytes_of(file(name));
  }

  // A recording whose recorder died: `checkpoint` after how many frames, 0 for never.
  Bytes unfinished(const char* name, int frames, int checkpoint) const {
    const test::RecordingScene scene;
    OniContent content;
    content.camera.model = {scene.width, scene.height, 58, 58, 31.5, 23.5, {}};
    content.color = ColorCoding::kRaw;
    auto writer = OniWriter::create(file(name), content, file::Existing::kReplace);
    EXPECT_TRUE(writer);
    for (int i = 0; i < frames; ++i) {
      EXPECT_TRUE(writer->write_depth(microseconds(1000 + 33'333 * i), scene.depth_of(i)));
      EXPECT_TRUE(writer->write_color(microseconds(8000 + 33'333 * i), scene.color_of(i)));
      if (checkpoint && (i + 1) % checkpoint == 0) {
        EXPECT_TRUE(writer->checkpoint());
      }
    }
    return bytes_of(file(name));
  }

  // How many frames of each stream it holds, every one as it was written.
  static std::pair<std::size_t, std::size_t> frames_in(const std::string& path, int first = 0) {
    const auto reader = OniReader::open(path);
    EXPECT_TRUE(reader) << reader.error().what;
    if (!reader) return {};
    const std::size_t depth = reader->summary().find(Kind::kDepth)->frames();
    const std::size_t color = reader->summary().find(Kind::kColor)->frames();
    for (std::size_t i = 0; i < depth; ++i) {
      EXPECT_EQ(*reader->depth(i), test::RecordingScene().depth_of(first + static_cast<int>(i))) << i;
    }
    for (std::size_t i = 0; i < color; ++i) {
      EXPECT_EQ(*reader->color(i), test::RecordingScene().color_of(first + static_cast<int>(i))) << i;
    }
    return {depth, color};
  }

  const test::TemporaryFolder folder_;
};

TEST_F(OniRepair, LeavesAWholeRecordingAlone) {
  const Bytes before = write("a.oni");
  const auto report = repair(file("a.oni"), "", file::Existing::kKeep, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_TRUE(report->was_whole);
  EXPECT_EQ(report->depth_frames, 12u);
  EXPECT_EQ(report->color_frames, 12u);
  EXPECT_EQ(bytes_of(file("a.oni")), before);
}

TEST_F(OniRepair, FinishesWhatADeadRecorderLeft) {
  unfinished("a.oni", 7, 0);
  EXPECT_FALSE(check(file("a.oni")));
  const auto report = repair(file("a.oni"), "", file::Existing::kKeep, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_FALSE(report->was_whole);
  EXPECT_EQ(frames_in(file("a.oni")), std::pair(std::size_t{7}, std::size_t{7}));
}

TEST_F(OniRepair, TakesInTheFramesBehindTheLastCheckpoint) {
  unfinished("a.oni", 7, 3);
  EXPECT_EQ(frames_in(file("a.oni")).first, 6u);
  ASSERT_TRUE(repair(file("a.oni"), "", file::Existing::kKeep, kNobodyWatches));
  EXPECT_EQ(frames_in(file("a.oni")), std::pair(std::size_t{7}, std::size_t{7}));
}

TEST_F(OniRepair, KeepsEveryWholeFrameWhereverTheFileIsCut) {
  const Bytes whole = unfinished("whole.oni", 3, 2);
  const auto frames = [&] {
    std::vector<std::size_t> ends;
    for (std::size_t at = kHeaderBytes; at + kRecordBytes <= whole.size();) {
      const std::size_t end = at + test::number_at<std::uint32_t>(whole, at + 12) +
                              (test::number_at<std::uint32_t>(whole, at + 4) == 0x0A
                                   ? test::number_at<std::uint32_t>(whole, at + 16)
                                   : 0);
      if (test::number_at<std::uint32_t>(whole, at + 4) == 0x0A) ends.push_back(end);
      at = end;
    }
    return ends;
  }();
  ASSERT_EQ(frames.size(), 6u);
  for (std::size_t size = frames[0]; size <= whole.size(); size += size % 7 == 0 ? 501 : 97) {
    test::write_bytes(file("cut.oni"),
                      Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    const auto report = repair(file("cut.oni"), "", file::Existing::kKeep, kNobodyWatches);
    ASSERT_TRUE(report) << size << ": " << report.error().what;
    const auto expected = std::count_if(frames.begin(), frames.end(), [&](auto end) { return end <= size; });
    ASSERT_EQ(report->depth_frames + report->color_frames, static_cast<std::uint64_t>(expected)) << size;
    const auto [depth, color] = frames_in(file("cut.oni"));
    ASSERT_EQ(depth + color, static_cast<std::size_t>(expected)) << size;
  }
}

TEST_F(OniRepair, WritesACopyAndLeavesTheOriginal) {
  const Bytes before = unfinished("a.oni", 5, 0);
  ASSERT_TRUE(repair(file("a.oni"), file("b.oni"), file::Existing::kKeep, kNobodyWatches));
  EXPECT_EQ(bytes_of(file("a.oni")), before);
  EXPECT_EQ(frames_in(file("b.oni")).first, 5u);
  EXPECT_EQ(repair(file("a.oni"), file("a.oni"), file::Existing::kKeep, kNobodyWatches).error().code,
            ErrorCode::kInvalid);
}

TEST_F(OniRepair, PassesOverDamageInTheMiddleInACopyOnly) {
  Bytes bytes = write("a.oni");
  const auto frame = records_of(bytes, RecordType::kNewData, kDepthNode)[4];
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(frame.at), 20, std::uint8_t{0});
  test::write_bytes(file("a.oni"), bytes);
  EXPECT_THAT(repair(file("a.oni"), "", file::Existing::kKeep, kNobodyWatches).error().what,
              HasSubstr("--out"));
  EXPECT_EQ(bytes_of(file("a.oni")), bytes);
  const auto report = repair(file("a.oni"), file("b.oni"), file::Existing::kKeep, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->gaps, 1u);
  const auto summary = check(file("b.oni"));
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_EQ(summary->find(Kind::kDepth)->frames(), 11u);
  EXPECT_EQ(summary->find(Kind::kColor)->frames(), 12u);
}

TEST_F(OniRepair, SaysSoWhereThereIsNothingToSave) {
  test::write_bytes(file("a.oni"), Bytes(100, 'x'));
  EXPECT_THAT(repair(file("a.oni"), "", file::Existing::kKeep, kNobodyWatches).error().what,
              HasSubstr("not an OpenNI recording"));
  const Bytes bytes = write("b.oni");
  test::write_bytes(file("b.oni"), Bytes(bytes.begin(), bytes.begin() + 40));
  EXPECT_THAT(repair(file("b.oni"), "", file::Existing::kKeep, kNobodyWatches).error().what,
              HasSubstr("nothing of it can be saved"));
  EXPECT_EQ(repair(file("missing.oni"), "", file::Existing::kKeep, kNobodyWatches).error().code,
            ErrorCode::kNotFound);
}

TEST_F(OniRepair, SurvivesEveryFlippedByteOutsideThePayloads) {
  const Bytes bytes = write("whole.oni", {.width = 16, .height = 16, .frames = 2});
  for (const auto& record : records_of(bytes)) {
    for (std::size_t at = record.at; at < record.payload_at; at += 3) {
      Bytes damaged = bytes;
      damaged[at] ^= 0xff;
      test::write_bytes(file("a.oni"), damaged);
      if (const auto report = repair(file("a.oni"), file("b.oni"), file::Existing::kReplace, kNobodyWatches);
          report) {
        ASSERT_TRUE(check(file("b.oni"))) << at;
      } else {
        ASSERT_FALSE(report.error().what.empty());
      }
    }
  }
}

TEST_F(OniRepair, CutsATimeOutOfARecording) {
  write("a.oni", {.color_after_us = 0});
  const auto report = cut(file("a.oni"), 0.1, 0.2, file("b.oni"), file::Existing::kKeep, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  // Frames at 0, 33.333 ms, ...: the last one before 0.1 s is number 3.
  EXPECT_EQ(report->depth_frames, 3u);
  EXPECT_EQ(frames_in(file("b.oni"), 4), std::pair(std::size_t{3}, std::size_t{3}));
  EXPECT_EQ(check(file("b.oni"))->find(Kind::kDepth)->timestamps_us.front(), 5'000'000u + 4 * 33'333);
  EXPECT_EQ(cut(file("a.oni"), 5, 6, file("c.oni"), file::Existing::kKeep, kNobodyWatches).error().code,
            ErrorCode::kInvalid);
  EXPECT_FALSE(std::filesystem::exists(file("c.oni")));
}

TEST_F(OniRepair, CutsARecordingOfOpenNisOwn) {
  const auto path = test::real_recording("arm_small.oni");
  if (!path) GTEST_SKIP() << "SKIPPED: no real recordings on this machine (COPRESENCE_RECORDINGS)";
  const auto before = OniReader::open(*path);
  ASSERT_TRUE(before);
  ASSERT_TRUE(cut(*path, 0, 0.15, file("a.oni"), file::Existing::kKeep, kNobodyWatches));
  const auto after = OniReader::open(file("a.oni"));
  ASSERT_TRUE(after) << after.error().what;
  const std::size_t frames = after->summary().find(Kind::kDepth)->frames();
  EXPECT_GT(frames, 1u);
  EXPECT_LT(frames, before->summary().find(Kind::kDepth)->frames());
  for (std::size_t i = 0; i < frames; ++i) EXPECT_EQ(*after->depth(i), *before->depth(i));
}

TEST_F(OniRepair, FinishesARecordingOfOpenNisOwnThatWasCutOff) {
  const auto path = test::real_recording("arm_small.oni");
  if (!path) GTEST_SKIP() << "SKIPPED: no real recordings on this machine (COPRESENCE_RECORDINGS)";
  Bytes bytes = bytes_of(*path);
  bytes.resize(bytes.size() / 2);
  test::write_bytes(file("a.oni"), bytes);
  EXPECT_FALSE(check(file("a.oni")));
  const auto report = repair(file("a.oni"), "", file::Existing::kKeep, kNobodyWatches);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_TRUE(OniReader::open(file("a.oni")));
}

TEST_F(OniRepair, NeverOverwritesAFileUnasked) {
  write("a.oni");
  test::write_bytes(file("b.oni"), Bytes(10, 'x'));
  for (const auto& error :
       {repair(file("a.oni"), file("b.oni"), file::Existing::kKeep, kNobodyWatches).error(),
        cut(file("a.oni"), 0, 1, file("b.oni"), file::Existing::kKeep, kNobodyWatches).error()}) {
    EXPECT_EQ(error.code, ErrorCode::kInvalid);
    EXPECT_THAT(error.what, testing::AllOf(HasSubstr("b.oni"), HasSubstr("--overwrite")));
  }
  EXPECT_EQ(bytes_of(file("b.oni")), Bytes(10, 'x'));
  EXPECT_TRUE(cut(file("a.oni"), 0, 1, file("b.oni"), file::Existing::kReplace, kNobodyWatches));
  EXPECT_TRUE(repair(file("a.oni"), file("b.oni"), file::Existing::kReplace, kNobodyWatches));
}

TEST_F(OniRepair, CutsAndFinishesRecordingsOfOpenNi1InTodaysFormat) {
  for (const std::uint32_t build : {4u, 5u, 6u}) {
    Bytes old = test::as_old_version(write("new.oni", {.color_after_us = 0}), build);
    test::write_bytes(file("old.oni"), old);
    const auto part =
        cut(file("old.oni"), 0.1, 0.2, file("part.oni"), file::Existing::kReplace, kNobodyWatches);
    ASSERT_TRUE(part) << build << ": " << part.error().what;
    EXPECT_EQ(frames_in(file("part.oni"), 4).first, 3u) << build;
    // Without its end, in the middle of its last frame.
    old.resize(old.size() - 500);
    test::write_bytes(file("old.oni"), old);
    EXPECT_THAT(repair(file("old.oni"), "", file::Existing::kKeep, kNobodyWatches).error().what,
                HasSubstr("--out"));
    const auto report = repair(file("old.oni"), file("whole.oni"), file::Existing::kReplace, kNobodyWatches);
    ASSERT_TRUE(report) << build << ": " << report.error().what;
    EXPECT_EQ(report->depth_frames, 12u) << build;
    EXPECT_EQ(frames_in(file("whole.oni")), std::pair(std::size_t{12}, std::size_t{11})) << build;
  }
}

TEST_F(OniRepair, APartKnowsWhenItBeganByTheClock) {
  OniContent content;
  content.camera.model = {64, 48, 58, 58, 32, 24, {}};
  content.color.reset();
  content.unix_zero_us = 1'650'000'000'000'000;
  auto writer = OniWriter::create(file("a.oni"), content);
  ASSERT_TRUE(writer) << writer.error().what;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(writer->write_depth(std::chrono::milliseconds(100 * i), DepthImage(64, 48, 900)));
  }
  ASSERT_TRUE(writer->finish());
  ASSERT_TRUE(cut(file("a.oni"), 0.5, 2, file("b.oni"), file::Existing::kKeep, kNobodyWatches));
  const auto part = check(file("b.oni"));
  ASSERT_TRUE(part) << part.error().what;
  EXPECT_EQ(part->unix_zero_us, 1'650'000'000'000'000);
  EXPECT_EQ(part->find(Kind::kDepth)->timestamps_us.front(), 500'000u);
}

}  // namespace
}  // namespace copresence::recording
