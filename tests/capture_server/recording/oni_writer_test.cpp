#include "capture_server/recording/oni_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "capture_server/recording/depth_16z.h"
#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_format.h"

namespace copresence::recording {
namespace {

using std::chrono::microseconds;

struct Record {
  RecordType type{};
  std::uint32_t node = 0;
  std::uint64_t position = 0, undo = 0;
  std::string fields, payload;
};

class OniWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_);
    content_.camera.model = {64, 48, 58, 58, 31.5, 23.5, {}};
    content_.camera.name = "one";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const char* name) const { return (folder_ / name).string(); }

  DepthImage depth(int frame) const {
    DepthImage image(64, 48);
    for (int i = 0; i < 64 * 48; ++i)
      image.data()[i] = static_cast<std::uint16_t>(i % 7 == 0 ? 0 : 600 + i % 90 + frame);
    return image;
  }
  ColorImage color() const { return ColorImage(64, 48, {200, 100, 50}); }

  void write(const std::string& to, int frames) {
    auto writer = OniWriter::create(to, content_, file::Existing::kReplace);
    ASSERT_TRUE(writer) << writer.error().what;
    for (int i = 0; i < frames; ++i) {
      ASSERT_TRUE(writer->write_depth(microseconds(5'000'000 + 33'333 * i), depth(i)));
      if (content_.color) {
        ASSERT_TRUE(writer->write_color(microseconds(5'007'000 + 33'333 * i), color()));
      }
    }
    ASSERT_TRUE(writer->finish());
  }

  static std::string bytes_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  template <class T>
  static T number_at(const std::string& bytes, std::size_t at) {
    T value;
    EXPECT_LE(at + sizeof(T), bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
  }
  static std::vector<Record> records_of(const std::string& bytes) {
    std::vector<Record> records;
    std::size_t at = kHeaderBytes;
    while (at + kRecordBytes <= bytes.size()) {
      EXPECT_EQ(number_at<std::uint32_t>(bytes, at), kRecordMagic);
      const auto fields = number_at<std::uint32_t>(bytes, at + 12),
                 payload = number_at<std::uint32_t>(bytes, at + 16);
      records.push_back(
          {RecordType{number_at<std::uint32_t>(bytes, at + 4)}, number_at<std::uint32_t>(bytes, at + 8), at,
           number_at<std::uint64_t>(bytes, at + 20), bytes.substr(at + kRecordBytes, fields - kRecordBytes),
           bytes.substr(at + fields, payload)});
      at += fields + payload;
    }
    EXPECT_EQ(at, bytes.size());
    return records;
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("copresence_oni_writer_" + std::to_string(getpid()));
  OniContent content_;
};

TEST_F(OniWriterTest, WritesAnUnbrokenRecordChainThatEnds) {
  write(path("a.oni"), 3);
  const std::string bytes = bytes_of(path("a.oni"));
  EXPECT_EQ(bytes.substr(0, 4), "NI10");
  EXPECT_EQ(number_at<std::uint64_t>(bytes, kHeaderTimestampAt), 5'007'000u + 2 * 33'333u);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, kHeaderNodeAt), 2u);
  EXPECT_EQ(records_of(bytes).back().type, RecordType::kEnd);
}

TEST_F(OniWriterTest, KeepsEachStreamsOwnTimestampsAndLinksItsFrames) {
  write(path("a.oni"), 3);
  const std::string bytes = bytes_of(path("a.oni"));
  for (const std::uint32_t node : {1u, 2u}) {
    std::uint64_t before = 0, count = 0;
    for (const Record& record : records_of(bytes)) {
      if (record.type != RecordType::kNewData || record.node != node) continue;
      EXPECT_EQ(number_at<std::uint64_t>(record.fields, 0),
                (node == 1 ? 5'000'000u : 5'007'000u) + 33'333 * count);
      EXPECT_EQ(number_at<std::uint32_t>(record.fields, 8), ++count);
      EXPECT_EQ(record.undo, before);
      before = record.position;
    }
    EXPECT_EQ(count, 3u);
  }
}

TEST_F(OniWriterTest, NodeRecordsCountTheFramesAndFindTheSeekTable) {
  write(path("a.oni"), 3);
  const std::string bytes = bytes_of(path("a.oni"));
  const auto records = records_of(bytes);
  for (const Record& added : records) {
    if (added.type != RecordType::kNodeAdded) continue;
    const std::size_t counts = 4 + 6 + 8;  // name, type, codec
    EXPECT_EQ(number_at<std::uint32_t>(added.fields, counts), 3u);
    const auto table_at = number_at<std::uint64_t>(added.fields, counts + 20);
    for (const Record& table : records) {
      if (table.position != table_at) continue;
      EXPECT_EQ(table.type, RecordType::kSeekTable);
      ASSERT_EQ(table.payload.size(), 4 * kSeekEntryBytes);
      const auto frame_at = number_at<std::uint64_t>(table.payload, 3 * kSeekEntryBytes + 12);
      EXPECT_EQ(number_at<std::uint32_t>(bytes, frame_at + 4),
                static_cast<std::uint32_t>(RecordType::kNewData));
    }
  }
}

TEST_F(OniWriterTest, DepthPayloadsExpandToWhatWasWritten) {
  write(path("a.oni"), 2);
  int frame = 0;
  for (const Record& record : records_of(bytes_of(path("a.oni")))) {
    if (record.type != RecordType::kNewData || record.node != 1) continue;
    DepthImage back(64, 48);
    ASSERT_TRUE(expand_depth_16z(
        {reinterpret_cast<const std::uint8_t*>(record.payload.data()), record.payload.size()},
        DepthTable::kEmbedded, back));
    EXPECT_EQ(back, depth(frame++));
  }
  EXPECT_EQ(frame, 2);
}

TEST_F(OniWriterTest, CarriesTheCameraMetadata) {
  content_.camera.registered = true;
  content_.camera.world_from_camera = Rigid3{Eigen::Matrix3d::Identity(), {1, 2, 3}};
  write(path("a.oni"), 1);
  int notes = 0;
  for (const Record& record : records_of(bytes_of(path("a.oni")))) {
    const auto key = record.fields.find(kCameraMetadataProperty);
    if (record.type != RecordType::kGeneralProperty || key == std::string::npos) continue;
    const auto note = parse_camera_metadata(
        std::string_view(record.fields).substr(key + sizeof(kCameraMetadataProperty) + 4));
    ASSERT_TRUE(note) << note.error().what;
    EXPECT_EQ(*note, content_.camera);
    ++notes;
  }
  EXPECT_EQ(notes, 1);
}

TEST_F(OniWriterTest, WritesTheSameBytesAgain) {
  write(path("a.oni"), 3);
  write(path("b.oni"), 3);
  EXPECT_EQ(bytes_of(path("a.oni")), bytes_of(path("b.oni")));
}

TEST_F(OniWriterTest, EmbedsAnExistingJpegUnchanged) {
  const std::vector<std::uint8_t> jpeg{0xFF, 0xD8, 1, 2, 3, 0xFF, 0xD9};
  auto writer = OniWriter::create(path("a.oni"), content_);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write_jpeg(microseconds(0), jpeg));
  ASSERT_TRUE(writer->finish());
  for (const Record& record : records_of(bytes_of(path("a.oni")))) {
    if (record.type == RecordType::kNewData) {
      EXPECT_EQ(record.payload, std::string(jpeg.begin(), jpeg.end()));
    }
  }
}

TEST_F(OniWriterTest, IsWholeAfterEveryCheckpoint) {
  auto writer = OniWriter::create(path("a.oni"), content_);
  ASSERT_TRUE(writer);
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(writer->write_depth(microseconds(33'333 * i), depth(i)));
    ASSERT_TRUE(writer->write_color(microseconds(33'333 * i + 7), color()));
    if (i > 0) {  // what came after the last checkpoint is not seen yet, and does no harm
      const auto so_far = check(path("a.oni"));
      ASSERT_TRUE(so_far) << so_far.error().what;
      EXPECT_EQ(so_far->find(RecordedStream::Kind::kDepth)->frames(), static_cast<std::size_t>(i));
    }
    ASSERT_TRUE(writer->checkpoint());
    const auto now = check(path("a.oni"));
    ASSERT_TRUE(now) << now.error().what;
    EXPECT_EQ(now->find(RecordedStream::Kind::kDepth)->frames(), static_cast<std::size_t>(i + 1));
    EXPECT_EQ(now->find(RecordedStream::Kind::kColor)->frames(), static_cast<std::size_t>(i + 1));
  }
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(check(path("a.oni"))->find(RecordedStream::Kind::kDepth)->frames(), 4u);
}

TEST_F(OniWriterTest, ACheckpointCostsAHundredBytes) {
  auto writer = OniWriter::create(path("a.oni"), content_);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write_depth(microseconds(0), depth(0)));
  const std::uint64_t before = writer->bytes();
  ASSERT_TRUE(writer->checkpoint());
  EXPECT_LE(writer->bytes(), before + 100);
  ASSERT_TRUE(writer->checkpoint());  // nothing has come since
  EXPECT_LE(writer->bytes(), before + 100);
}

TEST_F(OniWriterTest, AColorCameraOfItsOwnMayHaveAnotherSize) {
  content_.camera.color = ColorCameraMetadata{{128, 96, 110, 110, 63.5, 47.5, {}},
                                              Rigid3{Eigen::Matrix3d::Identity(), {0.025, 0, 0}}};
  auto writer = OniWriter::create(path("a.oni"), content_);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write_depth(microseconds(0), depth(0)));
  EXPECT_FALSE(writer->write_color(microseconds(0), color()));
  ASSERT_TRUE(writer->write_color(microseconds(0), ColorImage(128, 96)));
  ASSERT_TRUE(writer->finish());
  const auto summary = check(path("a.oni"));
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_EQ(summary->find(RecordedStream::Kind::kColor)->width, 128);
  EXPECT_EQ(summary->camera_metadata, content_.camera);
}

TEST_F(OniWriterTest, HoldsEveryDepthWhereItIsToldSo) {
  content_.max_depth = 65535;
  auto writer = OniWriter::create(path("a.oni"), content_);
  ASSERT_TRUE(writer);
  EXPECT_TRUE(writer->write_depth(microseconds(0), DepthImage(64, 48, 65535)));
}

TEST_F(OniWriterTest, RefusesWhatDoesNotBelong) {
  auto writer = OniWriter::create(path("a.oni"), content_);
  ASSERT_TRUE(writer);
  EXPECT_EQ(writer->write_depth(microseconds(0), DepthImage(32, 24)).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(writer->write_color(microseconds(0), ColorImage(32, 24)).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(writer->write_depth(microseconds(0), DepthImage(64, 48, 10001)).error().code,
            ErrorCode::kInvalid);
  EXPECT_EQ(writer->write_depth(microseconds(-1), depth(0)).error().code, ErrorCode::kInvalid);
  ASSERT_TRUE(writer->write_depth(microseconds(10), depth(0)));
  EXPECT_EQ(writer->write_depth(microseconds(9), depth(0)).error().code, ErrorCode::kInvalid);
}

TEST_F(OniWriterTest, SaysWhyAFileCannotBeWritten) {
  const auto nowhere = OniWriter::create(path("missing/a.oni"), content_);
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::kUnavailable);
  content_.camera.model.width = 63;
  EXPECT_EQ(OniWriter::create(path("a.oni"), content_).error().code, ErrorCode::kInvalid);
}

TEST_F(OniWriterTest, AFullDiskIsAnErrorAndNotASilence) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "NO /dev/full HERE";
  const auto writer = OniWriter::create("/dev/full", content_);
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(writer.error().what.find("disk is full"), std::string::npos) << writer.error().what;
}

}  // namespace
}  // namespace copresence::recording
