#include "capture_server/recording/oni_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/support/old_recording.h"
#include "tests/support/real_recordings.h"
#include "tests/support/recording_scene.h"

namespace copresence::recording {
namespace {

using test::bytes_of;
using test::kColorNode;
using test::kDepthNode;
using test::property_value_at;
using test::records_of;
using test::set_number_at;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;
using Kind = RecordedStream::Kind;

class OniCheck : public testing::Test {
 protected:
  Bytes whole(const test::RecordingScene& scene = {}) const {
    test::write_recording(folder_.file("whole.oni"), scene);
    return bytes_of(folder_.file("whole.oni"));
  }

  static std::string refusal(const Bytes& bytes, ErrorCode code = ErrorCode::kCorrupt) {
    const auto summary = check(bytes, "x.oni");
    if (summary) return "accepted";
    EXPECT_EQ(summary.error().code, code) << summary.error().what;
    EXPECT_THAT(summary.error().what, testing::StartsWith("x.oni: "));
    EXPECT_THAT(summary.error().what, testing::Not(testing::EndsWith(".")));
    return summary.error().what;
  }

  const test::TemporaryFolder folder_;
};

TEST_F(OniCheck, TellsWhatARecordingHolds) {
  const auto summary = check(whole(), "x.oni");
  ASSERT_TRUE(summary) << summary.error().what;
  ASSERT_EQ(summary->streams.size(), 2u);
  const RecordedStream& depth = *summary->find(Kind::kDepth);
  EXPECT_EQ(depth.codec, "16zT");
  EXPECT_EQ(depth.width, 64);
  EXPECT_EQ(depth.height, 48);
  EXPECT_EQ(depth.frames_per_second, 30);
  EXPECT_EQ(depth.unit, DepthUnit::kMillimetre);
  ASSERT_EQ(depth.frames(), 12u);
  EXPECT_EQ(depth.timestamps_us.front(), 5'000'000u);
  EXPECT_EQ(depth.timestamps_us.back(), 5'000'000u + 11 * 33'333);
  ASSERT_TRUE(depth.field_of_view);
  EXPECT_NEAR(depth.field_of_view->horizontal, 2 * std::atan(32 / 58.0), 1e-9);
  EXPECT_EQ(summary->find(Kind::kColor)->codec, "NONE");
  EXPECT_EQ(summary->find(Kind::kColor)->timestamps_us.front(), 5'007'000u);
  EXPECT_EQ(summary->duration, std::chrono::microseconds(12 * 33'333));
  ASSERT_TRUE(summary->camera_metadata);
  EXPECT_EQ(summary->camera_metadata->name, "one");
}

TEST_F(OniCheck, TakesARecordingWithoutColor) {
  const auto summary = check(whole({.color = std::nullopt, .unit = DepthUnit::k100Micrometres}), "x.oni");
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_EQ(summary->streams.size(), 1u);
  EXPECT_EQ(summary->find(Kind::kColor), nullptr);
  EXPECT_EQ(summary->find(Kind::kDepth)->unit, DepthUnit::k100Micrometres);
}

TEST_F(OniCheck, TakesWhateverStandsBehindTheEnd) {
  Bytes bytes = whole();
  bytes.resize(2 * bytes.size());  // OpenNI2's own recorder leaves as many zeros as there are bytes
  EXPECT_TRUE(check(bytes, "x.oni"));
}

TEST_F(OniCheck, ReadsAFileAsItReadsBytes) {
  const Bytes bytes = whole();
  const auto summary = check(folder_.file("whole.oni"));
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_EQ(summary->find(Kind::kDepth)->frames(), 12u);
}

TEST_F(OniCheck, RefusesWhatIsNoRecordingAtAll) {
  const std::string text = "hello\nhello\nhello\nhello\nhello\n";
  EXPECT_THAT(refusal({}), HasSubstr("empty"));
  EXPECT_THAT(refusal(Bytes(text.begin(), text.end())), HasSubstr("not an OpenNI recording"));
  EXPECT_EQ(check("/nonexistent/x.oni").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(check("/").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(check("/dev/zero").error().code, ErrorCode::kNotFound);
}

TEST_F(OniCheck, RefusesEveryTruncation) {
  const Bytes bytes = whole({.width = 16, .height = 16, .frames = 3});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_NE(refusal(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))), "accepted")
        << size;
  }
}

TEST_F(OniCheck, SaysWhereARecordingWasCutOff) {
  Bytes bytes = whole();
  const std::size_t at = records_of(bytes, RecordType::kNewData, kDepthNode)[4].at;
  bytes.resize(at + 100);
  EXPECT_THAT(refusal(bytes), HasSubstr("cut off: the record at byte " + std::to_string(at)));
  bytes.resize(at);
  EXPECT_THAT(refusal(bytes), HasSubstr("cut off at byte " + std::to_string(at)));
}

TEST_F(OniCheck, RefusesNodeIdsThatWouldMakeThePlayerAllocateGigabytes) {
  Bytes bytes = whole();
  set_number_at<std::uint32_t>(bytes, kHeaderNodeAt, 0x7fffffff);
  EXPECT_THAT(refusal(bytes), HasSubstr("2147483647"));
}

TEST_F(OniCheck, RefusesAVersionNobodyWrites) {
  Bytes bytes = whole();
  bytes[6] = 0;
  EXPECT_THAT(refusal(bytes, ErrorCode::kUnsupported), HasSubstr("version 1.0.0.0"));
}

TEST_F(OniCheck, RefusesRecordsThatThePlayerWouldLoseItsWayOn) {
  const Bytes bytes = whole();
  const auto frames = records_of(bytes, RecordType::kNewData, kDepthNode);
  const auto with = [&](std::size_t offset, std::uint32_t value) {
    Bytes damaged = bytes;
    set_number_at(damaged, frames[5].at + offset, value);
    return refusal(damaged);
  };
  const std::string at = "damaged at byte " + std::to_string(frames[5].at);
  EXPECT_THAT(with(0, 0), HasSubstr(at));                          // magic
  EXPECT_THAT(with(4, 99), HasSubstr("record type 99"));           // type
  EXPECT_THAT(with(8, 7), HasSubstr("unknown stream"));            // node
  EXPECT_THAT(with(12, 27), HasSubstr("fields"));                  // fields' size: below the header's
  EXPECT_THAT(with(12, 0x7fffffff), HasSubstr("fields"));          // ... beyond all bounds
  EXPECT_THAT(with(16, 0xffffffff), HasSubstr("goes on beyond"));  // payload's size
  EXPECT_THAT(with(28 + 4, 0x7f000000), HasSubstr("time"));        // time beyond the header's
  EXPECT_THAT(with(28 + 8, 0), HasSubstr("frame 5, then frame 0, of 12"));  // frame number
  EXPECT_THAT(with(28 + 8, 13), HasSubstr("frame 5, then frame 13, of 12"));
}

TEST_F(OniCheck, RefusesStreamsThatThePlayerWouldCrashOn) {
  const Bytes bytes = whole();
  const std::size_t added = records_of(bytes, RecordType::kNodeAdded, kDepthNode)[0].at + kRecordBytes;
  const std::size_t after_name = added + 4 + sizeof("Depth");
  Bytes damaged = bytes;
  damaged[added + 4] = 0xC4;  // the player's table is indexed by a signed character
  EXPECT_NE(refusal(damaged), "accepted");
  damaged = bytes;
  set_number_at<std::uint32_t>(damaged, added, 0xffffff00);  // name's length
  EXPECT_NE(refusal(damaged), "accepted");
  damaged = bytes;
  set_number_at<std::uint32_t>(damaged, after_name + 4,
                               0);  // a codec that is none: the player follows a null pointer
  EXPECT_THAT(refusal(damaged), HasSubstr("codec"));
  damaged = bytes;
  set_number_at<std::uint32_t>(damaged, after_name + 4, kCodecJpeg);
  EXPECT_THAT(refusal(damaged), HasSubstr("codec"));
  damaged = bytes;
  set_number_at<std::uint32_t>(damaged, after_name + 8, 0xffffffff);  // frames
  EXPECT_THAT(refusal(damaged), HasSubstr("4294967295 frames"));
  damaged = bytes;
  set_number_at<std::uint64_t>(damaged, after_name + 28, 24);  // seek table's position
  EXPECT_THAT(refusal(damaged), HasSubstr("seek table"));
}

TEST_F(OniCheck, RefusesPropertiesThatMakeNoSense) {
  const Bytes bytes = whole();
  const auto with = [&](const std::string& key, std::size_t offset, std::uint32_t value) {
    Bytes damaged = bytes;
    set_number_at(damaged, property_value_at(bytes, kDepthNode, key) + offset, value);
    const auto summary = check(damaged, "x.oni");
    return summary ? std::string("accepted") : summary.error().what;
  };
  EXPECT_THAT(with("xnMapOutputMode", 0, 63), HasSubstr("63x48"));  // odd
  EXPECT_THAT(with("xnMapOutputMode", 0, 0), HasSubstr("no size"));
  EXPECT_THAT(with("xnMapOutputMode", 4, 0x40000030), HasSubstr("xnMapOutputMode"));
  EXPECT_THAT(with("xnMapOutputMode", 0, 4000), HasSubstr("claims frames of 6144 bytes"));
  EXPECT_THAT(with("xnMapOutputMode", 8, 0), HasSubstr("xnMapOutputMode"));
  EXPECT_THAT(with("oniPixelFormat", 0, 102), HasSubstr("pixel format 102"));
  EXPECT_THAT(with("oniRequiredFrameSize", 0, 100), HasSubstr("claims frames of 100 bytes"));
  EXPECT_THAT(with("oniRequiredFrameSize", 4, 1), HasSubstr("oniRequiredFrameSize"));
  EXPECT_THAT(with("xnFOV", 4, 0x7ff00000), HasSubstr("xnFOV"));
  EXPECT_THAT(with("xnCropping", 0, 1), HasSubstr("cropped"));
  // A value's length that differs from what follows.
  EXPECT_NE(with("xnFOV", static_cast<std::size_t>(-4), 12), "accepted");
}

TEST_F(OniCheck, RefusesAStreamThatThePlayerWouldShowNothingOf) {
  const Bytes bytes = whole();
  for (const std::string key : {"xnCropping", "xnDeviceMaxDepth", "xnMapOutputMode"}) {
    Bytes damaged = bytes;
    damaged[property_value_at(bytes, kDepthNode, key) - 4 - 2] = '_';  // the key's last letter
    EXPECT_NE(refusal(damaged, key == "xnCropping" ? ErrorCode::kUnsupported : ErrorCode::kCorrupt),
              "accepted")
        << key;
  }
}

TEST_F(OniCheck, RefusesARawFrameOfAnotherSize) {
  const Bytes bytes = whole({.depth = DepthCoding::kNone});
  Bytes damaged = bytes;
  const auto frames = records_of(bytes, RecordType::kNewData, kDepthNode);
  damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(frames[3].payload_at),
                damaged.begin() + static_cast<std::ptrdiff_t>(frames[3].payload_at) + 2);
  set_number_at<std::uint32_t>(damaged, frames[3].at + 16,
                               static_cast<std::uint32_t>(frames[3].payload_bytes - 2));
  EXPECT_THAT(refusal(damaged), HasSubstr("takes 6142 bytes, exactly 6144 expected"));
}

TEST_F(OniCheck, RefusesARecordingWithoutDepth) {
  Bytes bytes = whole({.frames = 2});
  const std::size_t added = records_of(bytes, RecordType::kNodeAdded, kDepthNode)[0].at + kRecordBytes;
  set_number_at<std::uint32_t>(bytes, added + 4 + sizeof("Depth"),
                               static_cast<std::uint32_t>(NodeType::kInfrared));
  EXPECT_THAT(refusal(bytes, ErrorCode::kUnsupported), HasSubstr("no depth stream"));
}

TEST_F(OniCheck, NeverRefusesDamageInsidePayloads) {
  const Bytes bytes = whole();
  std::minstd_rand random(1);
  for (const auto& frame : records_of(bytes, RecordType::kNewData, kDepthNode)) {
    Bytes damaged = bytes;
    for (int i = 0; i < 10; ++i)
      damaged[frame.payload_at + random() % frame.payload_bytes] ^=
          static_cast<std::uint8_t>(1 << random() % 8);
    EXPECT_TRUE(check(damaged, "x.oni"));
  }
}

TEST_F(OniCheck, SurvivesEveryFlippedBitOutsideThePayloads) {
  const Bytes bytes = whole({.width = 16, .height = 16, .frames = 2});
  for (const auto& record : records_of(bytes)) {
    for (std::size_t at = record.at; at < record.payload_at; ++at) {
      for (int bit = 0; bit < 8; ++bit) {
        Bytes damaged = bytes;
        damaged[at] ^= static_cast<std::uint8_t>(1 << bit);
        const auto summary = check(damaged, "x.oni");  // refused or not: no crash, a sentence
        if (!summary) {
          ASSERT_FALSE(summary.error().what.empty());
        }
      }
    }
  }
}

TEST_F(OniCheck, TakesRealRecordings) {
  for (const char* name : {"arm_small.oni", "office.oni", "desk.oni", "person.oni", "office_view_a.oni"}) {
    const auto path = test::real_recording(name);
    if (!path) GTEST_SKIP() << "SKIPPED: no real recordings on this machine (COPRESENCE_RECORDINGS)";
    const auto summary = check(*path);
    ASSERT_TRUE(summary) << summary.error().what;
    EXPECT_EQ(summary->find(Kind::kDepth)->width, 640);
    EXPECT_EQ(summary->find(Kind::kColor) == nullptr, std::string(name) == "person.oni");
  }
}

TEST_F(OniCheck, ReadsTheVersionsOfOpenNi1) {
  const Bytes today = whole();
  for (const std::uint32_t build : {4u, 5u, 6u}) {
    const auto summary = check(test::as_old_version(today, build), "x.oni");
    ASSERT_TRUE(summary) << build << ": " << summary.error().what;
    EXPECT_EQ(summary->find(Kind::kDepth)->frames(), 12u);
    EXPECT_EQ(summary->find(Kind::kColor)->timestamps_us.back(), 5'007'000u + 11 * 33'333);
  }
}

TEST_F(OniCheck, SurvivesEveryFlippedByteOfAnOldVersion) {
  for (const std::uint32_t build : {4u, 6u}) {
    const Bytes old = test::as_old_version(whole({.width = 16, .height = 16, .frames = 2}), build);
    for (std::size_t at = 0; at < old.size(); ++at) {
      Bytes damaged = old;
      damaged[at] ^= 0xff;
      const auto summary = check(damaged, "x.oni");
      EXPECT_TRUE(summary || !summary.error().what.empty()) << at;
    }
  }
}

RecordedStream stream_at(std::vector<std::uint64_t> times) {
  RecordedStream stream;
  stream.frames_per_second = 30;
  stream.timestamps_us = std::move(times);
  return stream;
}

TEST(UsualPeriod, IsTheNominalOneWhereTimesSayNothing) {
  EXPECT_NEAR(usual_period_us(stream_at({})), 33'333.3, 0.1);
  EXPECT_NEAR(usual_period_us(stream_at({5, 5, 5, 5})), 33'333.3, 0.1);
  EXPECT_NEAR(usual_period_us(stream_at({0, 0, 0, 0, 0, 1'000'000})), 33'333.3, 0.1);
  EXPECT_NEAR(usual_period_us(stream_at({0, 33, 66, 100})), 33'333.3, 0.1)
      << "milliseconds, not microseconds";
  EXPECT_NEAR(usual_period_us(stream_at({0, 40'000, 80'000, 9'000'000, 9'040'000})), 40'000, 0.1)
      << "one jump";
  EXPECT_NEAR(usual_period_us(stream_at({0, 33'000, 67'000, 100'000})), 33'333.3, 0.1);
}

TEST(CheckPlayable, NamesFileAndMendWhereFramesAreTooFarApart) {
  EXPECT_TRUE(check_playable(stream_at({0, 33'333}), "a.oni"));
  EXPECT_TRUE(check_playable(stream_at({0, 5'000'000}), "a.oni"));
  const auto slow = check_playable(stream_at({0, 20'000'000, 40'000'000}), "a.oni");
  ASSERT_FALSE(slow);
  EXPECT_THAT(slow.error().what,
              testing::AllOf(testing::StartsWith("a.oni: "), HasSubstr("20 s"), HasSubstr("--times")));
}

TEST(OniWriterContent, RefusesBeforeItWritesWhatNobodyCouldPlay) {
  const test::TemporaryFolder folder;
  OniContent content;
  content.camera.model = {640, 480, 575, 575, 320, 240, {}};
  content.camera.registered = true;
  const auto refusal = [&](const OniContent& wrong) {
    const auto writer = OniWriter::create(folder.file("a.oni"), wrong);
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.oni")));
    return writer ? "accepted" : writer.error().what;
  };
  OniContent large = content;
  large.camera.model.width = large.camera.model.height = 4096;
  EXPECT_THAT(refusal(large), testing::HasSubstr("4096x4096"));
  OniContent large_color = content;
  large_color.camera.registered = false;
  large_color.camera.color = ColorCameraMetadata{{1920, 1080, 1000, 1000, 960, 540, {}}, {}};
  EXPECT_THAT(refusal(large_color), testing::HasSubstr("1920x1080"));
  OniContent flat = content;
  flat.camera.model.fx = 1e-300;
  EXPECT_NE(refusal(flat), "accepted");
  auto writer = OniWriter::create(folder.file("a.oni"), content);
  ASSERT_TRUE(writer) << writer.error().what;
  EXPECT_FALSE(
      writer->write_depth(std::chrono::microseconds(std::int64_t{1} << 57), DepthImage(640, 480, 900)));
}

}  // namespace
}  // namespace copresence::recording
