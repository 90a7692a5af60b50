#pragma once

// Writes an .oni recording that OpenNI 2 plays, without OpenNI: depth bit-exact, each stream with its own
// true timestamps, the same bytes for the same calls.
//
// Until finish() the file has no seek table and no counts: a program that dies leaves a file that can be
// repaired. Thread: one thread makes, uses and destroys a writer.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture_server/recording/camera_note.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

enum class DepthCoding { k16z, kNone };
enum class ColorCoding { kJpeg, kRaw };

/// What a recording holds, fixed before its first frame.
struct OniContent {
  CameraNote camera;  ///< size, unit and field of view of the streams come from it
  DepthCoding depth = DepthCoding::k16z;
  std::optional<ColorCoding> color = ColorCoding::kJpeg;
  int jpeg_quality = 90;  ///< 1 to 100
  int frames_per_second = 30;
};

class OniWriter {
 public:
  /// Makes (or empties) the file and writes what comes before the first frame.
  /// Fails  kInvalid for a content that cannot be, kUnavailable when the file cannot be written.
  static Result<OniWriter> create(const std::string& path, const OniContent& content);

  /// One depth picture, in the note's unit, of its size. `timestamp` is on the device's clock, at least 0 and
  /// not before that of the stream's last frame. Fails  kInvalid for a size, a time or a value beyond
  /// kMaxDepth... of oni_format.h; kUnavailable when the disk is full.
  Result<void> write_depth(std::chrono::microseconds timestamp, const DepthImage& depth);

  /// One colour picture of the note's size. Requires that the content has colour. Fails as write_depth().
  Result<void> write_color(std::chrono::microseconds timestamp, const ColorImage& color);

  /// One colour picture that is a JPEG file of the right size and three components already: its bytes go in
  /// unchanged. Requires ColorCoding::kJpeg.
  Result<void> write_jpeg(std::chrono::microseconds timestamp, std::span<const std::uint8_t> jpeg);

  /// Writes seek tables and counts and closes the file. Call it once, last.
  /// Fails  kUnavailable when the disk is full.
  Result<void> finish();

 private:
  struct Frame {
    std::uint64_t timestamp_us, position;
  };
  struct Stream {
    std::uint32_t node = 0;            // 1 depth, 2 colour
    std::uint64_t added_position = 0;  // of its kNodeAdded
    std::vector<Frame> frames;
  };
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  OniWriter(std::string path, OniContent content, std::unique_ptr<std::FILE, CloseFile> file)
      : path_(std::move(path)), content_(std::move(content)), file_(std::move(file)) {}

  void append_node(const Stream& stream, std::uint64_t seek_table_position);
  void append_properties(const Stream& stream);
  Result<void> append_frame(Stream& stream, std::chrono::microseconds timestamp,
                            std::span<const std::uint8_t> payload);
  Result<void> flush();  // pending_ to the file
  tl::unexpected<Error> disk_error(const char* doing) const;

  std::string path_;
  OniContent content_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::vector<std::uint8_t> pending_;  // records on their way to the file
  std::vector<std::uint8_t> payload_;
  std::uint64_t position_ = 0;  // where pending_ goes
  Stream depth_{1, 0, {}};
  Stream color_{2, 0, {}};
};

}  // namespace copresence::recording
