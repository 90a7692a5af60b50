#pragma once

// Writes an .oni recording that OpenNI 2 plays. Depth is bit-exact, each stream keeps its own
// timestamps, and the same calls write the same bytes.
//
// Frames are passed to the system at once. If the program dies, the file plays up to the last
// checkpoint(), and repair() (oni_repair.h) completes it up to the last whole frame.
//
// Thread: one thread creates, uses and destroys a writer.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture_server/recording/camera_metadata.h"
#include "capture_server/recording/jpeg.h"
#include "capture_server/recording/oni_footer.h"
#include "capture_server/recording/record_append.h"
#include "common/file/output_file.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

enum class DepthCoding { k16z, kNone };
enum class ColorCoding { kJpeg, kRaw };

/// The properties of a recording, fixed before its first frame.
struct OniContent {
  CameraMetadata camera;  ///< Gives the streams' sizes, unit and fields of view.
  DepthCoding depth = DepthCoding::k16z;
  std::optional<ColorCoding> color = ColorCoding::kJpeg;
  int jpeg_quality = 90;  ///< Quality of JPEG colour, 1 to 100.
  int frames_per_second = 30;
  /// Largest depth value, by which viewers size tables. The default is kMaxDepthMillimetre or
  /// kMaxDepth100Micrometres.
  std::optional<std::uint16_t> max_depth = std::nullopt;
  /// Microseconds from 1970 (UTC) to the recording's time zero, if known before the first frame.
  std::optional<std::int64_t> unix_zero_us = std::nullopt;
};

class OniWriter {
 public:
  /// Creates the file and writes the records before the first frame.
  /// Fails with kInvalid if the content is impossible, or if the file exists and `existing` is
  /// kKeep. Fails with kUnavailable if the file cannot be written.
  static Result<OniWriter> create(const std::string& path, const OniContent& content,
                                  file::Existing existing = file::Existing::kKeep);
  /// Creates the file under the first free name, see file::OutputFile::create_numbered().
  static Result<OniWriter> create_numbered(const std::string& path, const OniContent& content);

  const std::string& path() const { return path_; }

  /// Writes OniContent::unix_zero_us, if it became known only with the first frame. Requires that
  /// no frame has been written. Fails with kUnavailable if the disk is full.
  Result<void> note_unix_zero(std::int64_t unix_zero_us);

  /// Writes one depth picture in the unit and size of the content. `timestamp` is on the device's
  /// clock, at least 0 and not before the stream's previous frame. A failure leaves the file
  /// unchanged.
  /// Fails with kInvalid on a wrong size, time or depth. Fails with kUnsupported if the coding
  /// cannot represent the picture. Fails with kUnavailable if the disk is full.
  Result<void> write_depth(std::chrono::microseconds timestamp, const DepthImage& depth);

  /// Writes one colour picture of the colour camera's size. Requires a content with colour.
  /// Fails as write_depth() does.
  Result<void> write_color(std::chrono::microseconds timestamp, const ColorImage& color);

  /// Writes one colour picture that is already a JPEG of the right size with three components. The
  /// bytes are stored unchanged. Requires ColorCoding::kJpeg.
  Result<void> write_jpeg(std::chrono::microseconds timestamp, std::span<const std::uint8_t> jpeg);

  /// Completes the file up to here, so that it plays even after a crash. If there are new frames, a
  /// call adds a hundred bytes to the file. Fails with kUnavailable if the disk is full.
  Result<void> checkpoint();

  /// Writes seek tables and counts, and closes the file. Call it once, last. If the disk has no
  /// room for seek tables, the file is completed without them and still plays. Fails with
  /// kUnavailable if there is no room at all.
  Result<void> finish();

  /// Deletes the file. Call discard() instead of finish().
  void discard() { file_.discard(); }

  std::uint64_t bytes() const { return file_.size(); }

 private:
  struct Stream {
    std::uint32_t node = 0;  // Node id: 1 for depth, 2 for colour.
    std::uint64_t added_position = 0, counts_position = 0;
    std::vector<FramePlace> frames;
  };

  OniWriter(std::string path, OniContent content, file::OutputFile file)
      : path_(std::move(path)), content_(std::move(content)), file_(std::move(file)) {}

  static Result<OniWriter> begin(const OniContent& content, Result<file::OutputFile> file);
  const CameraModel& camera_of(const Stream& stream) const;
  std::uint16_t largest_depth() const;
  void append_definition(RecordBytesOut& bytes, Stream& stream);
  Result<void> append_frame(Stream& stream, std::chrono::microseconds timestamp,
                            std::span<const std::uint8_t> payload);
  Result<void> end(SeekTables seek_tables);

  std::string path_;
  OniContent content_;
  file::OutputFile file_;
  std::vector<std::uint8_t> payload_;
  JpegEncoder jpeg_;
  std::vector<std::uint8_t> record_;
  Stream depth_{1, 0, 0, {}};
  Stream color_{2, 0, 0, {}};
  std::optional<std::uint64_t> end_at_;  // Position of the last checkpoint.
  bool frames_since_ = false;            // True if frames were written after the last checkpoint.
};

}  // namespace copresence::recording
