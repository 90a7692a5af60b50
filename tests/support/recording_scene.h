#pragma once

// Makes small recordings with known pictures, which tests play, cut and damage.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "capture_server/recording/oni_format.h"
#include "capture_server/recording/oni_writer.h"

namespace copresence::test {

constexpr std::uint32_t kDepthNode = 1, kColorNode = 2;  // Numbers of the nodes, as in OniWriter.

/// A folder for one test. The destructor removes it.
class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_(std::filesystem::temp_directory_path() /
              ("copresence-" + std::to_string(::getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// Content of the recording that write_recording() writes.
struct RecordingScene {
  int width = 64, height = 48;
  int frames = 12;
  std::int64_t period_us = 33'333;
  std::int64_t first_us = 5'000'000;
  std::int64_t color_after_us = 7'000;  ///< Time of a colour picture minus that of its depth picture.
  bool color_first = false;             ///< Colour comes first in the file.
  recording::DepthCoding depth = recording::DepthCoding::k16z;
  std::optional<recording::ColorCoding> color = recording::ColorCoding::kRaw;
  std::vector<int> without_color = {};  ///< Frames, from 0, whose colour picture is missing.
  DepthUnit unit = DepthUnit::kMillimetre;

  /// Draws frames that all differ. A ninth of each frame is holes.
  DepthImage depth_of(int frame) const {
    DepthImage image(width, height);
    for (int i = 0; i < width * height; ++i) {
      image.data()[i] = static_cast<std::uint16_t>(i % 9 == 0 ? 0 : 600 + i % 90 + 11 * frame);
    }
    return image;
  }
  ColorImage color_of(int frame) const {
    return ColorImage(width, height, {static_cast<std::uint8_t>(20 * frame), 100, 50});
  }
};

inline void write_recording(const std::string& path, const RecordingScene& scene) {
  using std::chrono::microseconds;
  recording::OniContent content;
  content.camera.model = {
      scene.width, scene.height, 58, 58, scene.width / 2.0 - 0.5, scene.height / 2.0 - 0.5, {}};
  content.camera.name = "one";
  content.camera.registered = true;
  content.camera.unit = scene.unit;
  content.depth = scene.depth;
  content.color = scene.color;
  auto writer = recording::OniWriter::create(path, content, file::Existing::kReplace);
  ASSERT_TRUE(writer) << writer.error().what;
  for (int i = 0; i < scene.frames; ++i) {
    const std::int64_t time = scene.first_us + i * scene.period_us;
    const auto write_color = [&] {
      const bool missing =
          std::find(scene.without_color.begin(), scene.without_color.end(), i) != scene.without_color.end();
      if (!scene.color || missing) return;
      ASSERT_TRUE(writer->write_color(microseconds(time + scene.color_after_us), scene.color_of(i)));
    };
    if (scene.color_first) write_color();
    ASSERT_TRUE(writer->write_depth(microseconds(time), scene.depth_of(i)));
    if (!scene.color_first) write_color();
  }
  ASSERT_TRUE(writer->finish());
}

inline std::vector<std::uint8_t> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_bytes(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

template <class T>
T number_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  T value{};
  if (at + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}
template <class T>
void set_number_at(std::vector<std::uint8_t>& bytes, std::size_t at, T value) {
  ASSERT_LE(at + sizeof(T), bytes.size());
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

/// The position of a record in the bytes of a complete recording.
struct RecordPlace {
  recording::RecordType type{};
  std::uint32_t node = 0;
  std::size_t at = 0, payload_at = 0, payload_bytes = 0;
  std::size_t end() const { return payload_at + payload_bytes; }
};

/// Returns the records of a complete recording, in order.
inline std::vector<RecordPlace> records_of(const std::vector<std::uint8_t>& bytes) {
  using recording::RecordType;
  std::vector<RecordPlace> records;
  std::size_t at = recording::kHeaderBytes;
  while (at + recording::kRecordBytes <= bytes.size()) {
    RecordPlace record{RecordType{number_at<std::uint32_t>(bytes, at + 4)},
                       number_at<std::uint32_t>(bytes, at + 8), at,
                       at + number_at<std::uint32_t>(bytes, at + 12), 0};
    if (record.type == RecordType::kNewData || record.type == RecordType::kSeekTable) {
      record.payload_bytes = number_at<std::uint32_t>(bytes, at + 16);
    }
    records.push_back(record);
    if (record.type == RecordType::kEnd) break;
    at = record.end();
  }
  return records;
}

/// Returns the records of one type and node.
inline std::vector<RecordPlace> records_of(const std::vector<std::uint8_t>& bytes, recording::RecordType type,
                                           std::uint32_t node) {
  std::vector<RecordPlace> records = records_of(bytes);
  std::erase_if(records, [&](const RecordPlace& r) { return r.type != type || r.node != node; });
  return records;
}

/// Returns the position of the value of a node's property.
inline std::size_t property_value_at(const std::vector<std::uint8_t>& bytes, std::uint32_t node,
                                     const std::string& key) {
  for (const RecordPlace& record : records_of(bytes)) {
    const std::size_t name_at = record.at + recording::kRecordBytes + 4;
    if (record.node == node && record.type >= recording::RecordType::kIntProperty &&
        record.type <= recording::RecordType::kGeneralProperty && name_at + key.size() + 1 <= bytes.size() &&
        std::memcmp(bytes.data() + name_at, key.c_str(), key.size() + 1) == 0) {
      return name_at + key.size() + 1 + 4;
    }
  }
  ADD_FAILURE() << "no property " << key;
  return 0;
}

}  // namespace copresence::test
