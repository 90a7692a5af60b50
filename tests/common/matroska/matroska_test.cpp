// Files that Writer writes, as Reader reads them: whole, unfinished, cut off and damaged.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <utility>

#include "common/matroska/ebml.h"
#include "common/matroska/reader.h"
#include "common/matroska/writer.h"
#include "tests/support/process.h"

namespace copresence::matroska {
namespace {

using ::testing::HasSubstr;

/// The content of block `number` of a track.
Bytes picture(std::uint64_t track, int number) {
  return Bytes(20 + 7 * static_cast<std::size_t>(number),
               static_cast<std::uint8_t>(16 * track + number % 16));
}

class MatroskaTest : public ::testing::Test {
 protected:
  static constexpr int kBlocks = 30;
  static constexpr Time kPeriod = std::chrono::milliseconds(50);

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Writer begin(const std::string& name, std::size_t head_bytes = 4096) {
    auto file = file::OutputFile::create(path(name));
    EXPECT_TRUE(file);
    auto writer =
        Writer::begin(std::move(*file), {.title = "a test", .program = "test", .head_bytes = head_bytes});
    EXPECT_TRUE(writer);
    return std::move(*writer);
  }

  /// Two tracks; the second one joins after ten blocks of the first.
  void write_blocks(Writer& writer) {
    ASSERT_TRUE(writer.add_attachment({"left.stream", "a description", "text/plain", Bytes{1, 2, 3}}));
    ASSERT_EQ(writer.add_track({.name = "left depth", .codec_private = {9, 8}, .width = 640, .height = 480}),
              1u);
    for (int i = 0; i < kBlocks; ++i) {
      if (i == 10) {
        ASSERT_EQ(writer.add_track({.name = "right", .width = 320, .height = 240, .is_default = false}), 2u);
      }
      ASSERT_TRUE(writer.write(i * kPeriod, {1, i % 8 == 0, picture(1, i)}));
      // It comes late, as a frame of a slower camera does.
      if (i >= 10) {
        ASSERT_TRUE(writer.write(i * kPeriod - kPeriod / 2, {2, i == 10, picture(2, i)}));
      }
    }
  }

  Bytes bytes_of(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write_bytes(const std::string& name, std::span<const std::uint8_t> bytes) const {
    std::ofstream(path(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

  static void expect_blocks(const Reader& reader, std::size_t of_first, std::size_t of_second) {
    ASSERT_EQ(reader.tracks().size(), 2u);
    ASSERT_EQ(reader.blocks(0).size(), of_first);
    ASSERT_EQ(reader.blocks(1).size(), of_second);
    for (int i = 0; i < static_cast<int>(of_first); ++i) {
      const BlockPlace& block = reader.blocks(0)[static_cast<std::size_t>(i)];
      EXPECT_EQ(block.time, i * kPeriod);
      EXPECT_EQ(block.is_keyframe, i % 8 == 0);
      EXPECT_EQ(*reader.read(block), picture(1, i));
    }
    for (int i = 0; i < static_cast<int>(of_second); ++i) {
      const BlockPlace& block = reader.blocks(1)[static_cast<std::size_t>(i)];
      EXPECT_EQ(block.time, (i + 10) * kPeriod - kPeriod / 2);
      EXPECT_EQ(*reader.read(block), picture(2, i + 10));
    }
  }

  copresence::testing::TemporaryFolder folder_;
};

TEST_F(MatroskaTest, AFileIsReadAsItWasWritten) {
  Writer writer = begin("a.mkv");
  write_blocks(writer);
  ASSERT_TRUE(writer.finish());
  const auto reader = Reader::open(path("a.mkv"));
  ASSERT_TRUE(reader) << reader.error().what;
  expect_blocks(*reader, kBlocks, kBlocks - 10);
  EXPECT_FALSE(reader->is_cut());
  EXPECT_EQ(reader->tracks()[0].name, "left depth");
  EXPECT_EQ(reader->tracks()[0].codec_private, (Bytes{9, 8}));
  EXPECT_EQ(reader->tracks()[0].width, 640);
  EXPECT_TRUE(reader->tracks()[0].is_default);
  EXPECT_FALSE(reader->tracks()[1].is_default);
  ASSERT_EQ(reader->attachments().size(), 1u);
  EXPECT_EQ(reader->attachments()[0].name, "left.stream");
  EXPECT_EQ(reader->attachments()[0].bytes, (Bytes{1, 2, 3}));
}

TEST_F(MatroskaTest, AFileThatWasNeverFinishedHasAllItsBlocks) {
  {
    Writer writer = begin("a.mkv");
    write_blocks(writer);
  }
  const auto reader = Reader::open(path("a.mkv"));
  ASSERT_TRUE(reader) << reader.error().what;
  expect_blocks(*reader, kBlocks, kBlocks - 10);
}

TEST_F(MatroskaTest, AFileThatIsCutOffHasTheWholeBlocksBeforeTheCut) {
  Writer writer = begin("a.mkv");
  write_blocks(writer);
  ASSERT_TRUE(writer.finish());
  const Bytes whole = bytes_of("a.mkv");
  std::size_t last = 0;
  for (std::size_t size = 4200; size < whole.size(); size += 101) {
    write_bytes("cut.mkv", std::span(whole).first(size));
    const auto reader = Reader::open(path("cut.mkv"));
    ASSERT_TRUE(reader) << reader.error().what;
    const std::size_t blocks = reader->blocks(0).size() + reader->blocks(1).size();
    EXPECT_GE(blocks, last);
    last = blocks;
    for (std::size_t i = 0; i < reader->blocks(0).size(); ++i)
      EXPECT_EQ(*reader->read(reader->blocks(0)[i]), picture(1, static_cast<int>(i)));
  }
  EXPECT_EQ(last, static_cast<std::size_t>(2 * kBlocks - 10));
}

TEST_F(MatroskaTest, ATrackThatFindsNoRoomIsRefusedAndTheFileStaysWhole) {
  Writer writer = begin("a.mkv", 400);
  ASSERT_TRUE(writer.add_track({.name = "one", .width = 64, .height = 48}));
  const auto second = writer.add_track({.name = std::string(300, 'x'), .width = 64, .height = 48});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(second.error().what, HasSubstr("no room for another track"));
  ASSERT_TRUE(writer.write(Time(5), {1, true, Bytes{1}}));
  ASSERT_TRUE(writer.finish());
  const auto reader = Reader::open(path("a.mkv"));
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->tracks().size(), 1u);
  EXPECT_EQ(reader->blocks(0).size(), 1u);
}

TEST_F(MatroskaTest, ABlockBetweenFarTimesIsWrittenWithItsOwnTime) {
  Writer writer = begin("a.mkv");
  ASSERT_TRUE(writer.add_track({.name = "one", .width = 64, .height = 48}));
  const std::vector<Time> times = {Time(100'000), Time(20), Time(70'000), Time(69'000), Time(900'000)};
  for (const Time time : times) ASSERT_TRUE(writer.write(time, {1, true, Bytes{1}}));
  const auto reader = Reader::open(path("a.mkv"));
  ASSERT_TRUE(reader);
  std::vector<Time> read;
  for (const BlockPlace& block : reader->blocks(0)) read.push_back(block.time);
  EXPECT_EQ(read, times);
}

TEST_F(MatroskaTest, OtherFilesAreRefusedWithASentence) {
  write_bytes("text.mkv", Bytes{'h', 'e', 'l', 'l', 'o'});
  write_bytes("empty.mkv", Bytes{});
  Bytes other;
  append_text(other, Id::kDocType, "other");
  Bytes header;
  append_bytes(header, Id::kEbml, other);
  write_bytes("other.mkv", header);
  EXPECT_THAT(Reader::open(path("text.mkv")).error().what, HasSubstr("is no Matroska file"));
  EXPECT_THAT(Reader::open(path("empty.mkv")).error().what, HasSubstr("has no tracks"));
  EXPECT_THAT(Reader::open(path("other.mkv")).error().what, HasSubstr("but \"other\""));
  EXPECT_EQ(Reader::open(path("missing.mkv")).error().code, ErrorCode::kNotFound);
}

// Any byte may be damaged. The reader may lose blocks, but it must neither crash nor return places
// outside the file.
TEST_F(MatroskaTest, DamagedFilesGiveFewerBlocksOrASentence) {
  Writer writer = begin("a.mkv", 1024);
  write_blocks(writer);
  ASSERT_TRUE(writer.finish());
  Bytes bytes = bytes_of("a.mkv");
  int refused = 0;
  for (std::size_t at = 0; at < bytes.size(); at += at < 600 ? 1 : 37) {
    for (const std::uint8_t damage : Bytes{0x01, 0xFF}) {
      const std::uint8_t before = std::exchange(bytes[at], static_cast<std::uint8_t>(bytes[at] ^ damage));
      write_bytes("b.mkv", bytes);
      const auto reader = Reader::open(path("b.mkv"));
      bytes[at] = before;
      if (!reader) {
        ++refused;
        EXPECT_THAT(reader.error().what, HasSubstr("b.mkv"));
        continue;
      }
      for (std::size_t track = 0; track < reader->tracks().size(); ++track) {
        for (const BlockPlace& block : reader->blocks(track)) {
          EXPECT_LE(block.offset + block.bytes, bytes.size());
          EXPECT_GE(block.time.count(), 0);
        }
      }
    }
  }
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace copresence::matroska
