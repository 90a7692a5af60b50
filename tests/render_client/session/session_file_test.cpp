// Session recordings that SessionWriter writes, as SessionFile reads them.

#include "render_client/session/session_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/bitstream/access_unit.h"
#include "common/bitstream/side_data.h"
#include "common/video/frame_decoder.h"
#include "render_client/session/session_writer.h"
#include "tests/render_client/session/coded_stream.h"
#include "tests/support/process.h"

namespace copresence::session {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

constexpr milliseconds kPeriod{33};
const Instant kBegan = Instant(std::chrono::hours(5));

/// Whether both access units have the same NAL units.
bool are_equal(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  const auto nals_a = bitstream::split_access_unit(a), nals_b = bitstream::split_access_unit(b);
  return nals_a && nals_b &&
         std::equal(nals_a->begin(), nals_a->end(), nals_b->begin(), nals_b->end(),
                    [](const bitstream::Nal& x, const bitstream::Nal& y) {
                      return std::equal(x.bytes.begin(), x.bytes.end(), y.bytes.begin(), y.bytes.end());
                    });
}

class SessionFileTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  SessionWriter create(const std::string& name) {
    auto writer = SessionWriter::create(path(name), kBegan);
    EXPECT_TRUE(writer);
    return std::move(*writer);
  }

  static void write(SessionWriter& writer, std::size_t camera, const CodedStream& stream,
                    const EncodedFrame& frame, Instant at) {
    const auto written = writer.write(camera, stream.description(), frame, at);
    ASSERT_TRUE(written) << written.error().what;
  }

  copresence::testing::TemporaryFolder folder_;
};

TEST_F(SessionFileTest, EveryAccessUnitIsReadAsItWasReceived) {
  CodedStream left("left"), right("right", false);
  std::vector<EncodedFrame> of_left, of_right;
  SessionWriter writer = create("a.mkv");
  for (int i = 0; i < 40; ++i) {
    of_left.push_back(left.next(i % 15 == 0));
    write(writer, 0, left, of_left.back(), kBegan + i * kPeriod);
    of_right.push_back(right.next(false));
    write(writer, 1, right, of_right.back(), kBegan + i * kPeriod + milliseconds(11));
  }
  ASSERT_TRUE(writer.finish());

  const auto file = SessionFile::open(path("a.mkv"));
  ASSERT_TRUE(file) << file.error().what;
  EXPECT_THAT(file->remarks(), ::testing::IsEmpty());
  ASSERT_EQ(file->cameras().size(), 2u);
  EXPECT_EQ(file->cameras()[0].name, "left");
  EXPECT_EQ(file->cameras()[1].name, "right");
  EXPECT_EQ(file->begin(), Time(0));
  EXPECT_EQ(file->end(), Time(39 * 330 + 110));
  const std::vector<EncodedFrame>* sent[] = {&of_left, &of_right};
  for (std::size_t camera = 0; camera < 2; ++camera) {
    ASSERT_EQ(file->cameras()[camera].streams.size(), 1u);
    const RecordedStream& stream = file->cameras()[camera].streams[0];
    EXPECT_EQ(stream.description, camera == 0 ? *left.description() : *right.description());
    ASSERT_EQ(stream.frames.size(), 40u);
    auto decoder = video::FrameDecoder::open(stream.description);
    ASSERT_TRUE(decoder);
    for (std::size_t i = 0; i < stream.frames.size(); ++i) {
      EXPECT_EQ(stream.frames[i].is_keyframe(), (*sent[camera])[i].keyframe);
      const auto read = file->read(stream.frames[i]);
      ASSERT_TRUE(read);
      EXPECT_TRUE(are_equal(read->depth, (*sent[camera])[i].depth));
      EXPECT_TRUE(camera == 1 ? read->color.empty() : are_equal(read->color, (*sent[camera])[i].color));
      EXPECT_TRUE(decoder->decode(*read)) << i;
    }
  }
}

TEST_F(SessionFileTest, ACameraThatConnectsAgainContinuesItsStream) {
  SessionWriter writer = create("a.mkv");
  CodedStream first("left"), again("left");
  write(writer, 0, first, first.next(true), kBegan);
  write(writer, 0, again, again.next(true), kBegan + std::chrono::seconds(3));
  ASSERT_TRUE(writer.finish());
  const auto file = SessionFile::open(path("a.mkv"));
  ASSERT_TRUE(file);
  ASSERT_EQ(file->cameras().size(), 1u);
  ASSERT_EQ(file->cameras()[0].streams.size(), 1u);
  EXPECT_EQ(file->cameras()[0].streams[0].frames.size(), 2u);
}

TEST_F(SessionFileTest, ACameraThatComesBackWithAnotherDescriptionGetsAnotherStream) {
  SessionWriter writer = create("a.mkv");
  CodedStream before("left"), changed("left", false), after("left");
  write(writer, 0, before, before.next(true), kBegan);
  write(writer, 0, changed, changed.next(true), kBegan + std::chrono::seconds(3));
  write(writer, 0, after, after.next(true), kBegan + std::chrono::seconds(6));
  ASSERT_TRUE(writer.finish());
  const auto file = SessionFile::open(path("a.mkv"));
  ASSERT_TRUE(file);
  ASSERT_EQ(file->cameras().size(), 1u);
  const auto& streams = file->cameras()[0].streams;
  ASSERT_EQ(streams.size(), 3u);
  EXPECT_TRUE(streams[0].description.has_color);
  EXPECT_FALSE(streams[1].description.has_color);
  EXPECT_TRUE(streams[2].description.has_color);
  EXPECT_EQ(streams[1].begin(), Time(30'000));
}

TEST_F(SessionFileTest, TwoCamerasOfOneNameStayTwoCameras) {
  SessionWriter writer = create("a.mkv");
  CodedStream one("kinect"), other("kinect");
  for (int i = 0; i < 5; ++i) {
    write(writer, 0, one, one.next(false), kBegan + i * kPeriod);
    write(writer, 1, other, other.next(false), kBegan + i * kPeriod);
  }
  ASSERT_TRUE(writer.finish());
  const auto file = SessionFile::open(path("a.mkv"));
  ASSERT_TRUE(file);
  ASSERT_EQ(file->cameras().size(), 2u);
  for (const RecordedCamera& camera : file->cameras()) EXPECT_EQ(camera.streams[0].frames.size(), 5u);
}

TEST_F(SessionFileTest, FramesOfOneInstantGetDifferentTimes) {
  SessionWriter writer = create("a.mkv");
  CodedStream left("left");
  for (int i = 0; i < 3; ++i) write(writer, 0, left, left.next(false), kBegan + milliseconds(10 - i));
  ASSERT_TRUE(writer.finish());
  const auto file = SessionFile::open(path("a.mkv"));
  ASSERT_TRUE(file);
  const auto& frames = file->cameras()[0].streams[0].frames;
  ASSERT_EQ(frames.size(), 3u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].time(), Time(100 + static_cast<int>(i)));
    EXPECT_TRUE(frames[i].color);
  }
}

TEST_F(SessionFileTest, NeverOverwritesAFile) {
  std::ofstream(path("a.mkv")) << "mine";
  SessionWriter writer = create("a.mkv");
  EXPECT_EQ(writer.path(), path("a-2.mkv"));
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(std::filesystem::file_size(path("a.mkv")), 4u);
}

TEST_F(SessionFileTest, AFullDiskEndsTheFileAfterItsLastWholeFrame) {
  SessionWriter writer = create("a.mkv");
  CodedStream left("left");
  write(writer, 0, left, left.next(true), kBegan);
  // No byte may be written beyond this size: the limit has the effect of a full disk.
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit full{writer.bytes() + 3000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  Result<void> written;
  int frames = 1;
  for (; written && frames < 1000; ++frames)
    written = writer.write(0, left.description(), left.next(false), kBegan + frames * kPeriod);
  const auto finished = writer.finish();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(written.error().what, HasSubstr("a.mkv"));
  EXPECT_TRUE(finished);
  const auto file = SessionFile::open(path("a.mkv"));
  ASSERT_TRUE(file) << file.error().what;
  EXPECT_EQ(file->cameras()[0].streams[0].frames.size(), static_cast<std::size_t>(frames - 1));
}

TEST_F(SessionFileTest, AMatroskaFileWithoutDescriptionsIsNoSession) {
  auto output = file::OutputFile::create(path("film.mkv"));
  ASSERT_TRUE(output);
  auto film = matroska::Writer::begin(std::move(*output), {.program = "test"});
  ASSERT_TRUE(film);
  ASSERT_TRUE(film->add_track({.name = "view", .width = 64, .height = 48}));
  ASSERT_TRUE(film->finish());
  const auto file = SessionFile::open(path("film.mkv"));
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().what, HasSubstr("holds no session"));
}

// A damaged file may lose frames or cameras. It must neither crash nor give a picture that differs
// from the recorded one.
TEST_F(SessionFileTest, DamagedRecordingsGiveTheSamePicturesOrNone) {
  std::vector<EncodedFrame> sent;
  {
    SessionWriter writer = create("a.mkv");
    CodedStream left("left");
    for (int i = 0; i < 12; ++i) {
      sent.push_back(left.next(i % 5 == 0));
      write(writer, 0, left, sent.back(), kBegan + i * kPeriod);
    }
  }
  std::ifstream in(path("a.mkv"), std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  std::uint32_t random = 1;
  int refused = 0, decoded = 0;
  for (int round = 0; round < 400; ++round) {
    std::vector<char> damaged = bytes;
    for (int change = 0; change <= round % 4; ++change) {
      random = video::noise(random + 0x9E3779B9u);
      // Two of three changes are in the head with tracks and descriptions, the rest in the frames.
      const std::size_t head = 1500, body = 128 * 1024;
      const std::size_t at = round % 3 != 0 ? random % head : body + random % (bytes.size() - body);
      damaged[at] = static_cast<char>(video::noise(random));
    }
    if (round % 7 == 0)
      damaged.erase(damaged.end() - static_cast<std::ptrdiff_t>(random % 4000), damaged.end());
    std::ofstream(path("b.mkv"), std::ios::binary)
        .write(damaged.data(), static_cast<std::streamsize>(damaged.size()));
    const auto file = SessionFile::open(path("b.mkv"));
    if (!file) {
      ++refused;
      EXPECT_THAT(file.error().what, HasSubstr("b.mkv"));
      continue;
    }
    for (const RecordedCamera& camera : file->cameras()) {
      for (const RecordedFrame& frame : camera.streams[0].frames) {
        const auto read = file->read(frame);
        if (!read) continue;
        // The checksum of the side data covers both pictures.
        const auto data = bitstream::extract_side_data(read->depth, read->color);
        if (!data) continue;
        ++decoded;
        ASSERT_LE(data->sequence, sent.size());
        EXPECT_TRUE(are_equal(read->depth, sent[data->sequence - 1].depth));
      }
    }
  }
  EXPECT_GT(refused, 10);
  EXPECT_GT(decoded, 1000);
}

}  // namespace
}  // namespace copresence::session
