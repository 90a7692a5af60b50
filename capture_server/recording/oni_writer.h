#pragma once

// Writes an .oni recording that OpenNI 2 plays, without OpenNI: depth bit-exact, each stream with its own
// true timestamps, the same bytes for the same calls.
//
// Frames go to the system as they come. A program that dies leaves a file that plays up to the last
// checkpoint(), and that repair() (recording/oni_repair.h) completes up to the last whole frame.
//
// Thread: one thread makes, uses and destroys a writer.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture_server/recording/camera_note.h"
#include "capture_server/recording/jpeg.h"
#include "capture_server/recording/output_file.h"
#include "capture_server/recording/record_append.h"
#include "capture_server/recording/record_end.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

enum class DepthCoding { k16z, kNone };
enum class ColorCoding { kJpeg, kRaw };

/// What a recording holds, fixed before its first frame.
struct OniContent {
  CameraNote camera;  ///< sizes, unit and fields of view of the streams come from it
  DepthCoding depth = DepthCoding::k16z;
  std::optional<ColorCoding> color = ColorCoding::kJpeg;
  int jpeg_quality = 90;  ///< 1 to 100
  int frames_per_second = 30;
  /// Largest depth value, for viewers that size tables by it; nothing: kMaxDepth... of oni_format.h.
  std::optional<std::uint16_t> max_depth = std::nullopt;
  /// Microseconds from 1970 (UTC) to the recording's time zero, where it is known before the first frame.
  std::optional<std::int64_t> unix_zero_us = std::nullopt;
};

class OniWriter {
 public:
  /// Creates the file and writes what comes before the first frame.
  /// Fails  kInvalid for a content that cannot be or, with kKeep, a file that exists; kUnavailable when the
  ///        file cannot be written.
  static Result<OniWriter> create(const std::string& path, const OniContent& content,
                                  Existing existing = Existing::kKeep);
  /// The same under the first free name, see OutputFile::create_numbered().
  static Result<OniWriter> create_numbered(const std::string& path, const OniContent& content);

  const std::string& path() const { return path_; }

  /// Notes when the recording's time zero was by the clock: OniContent::unix_zero_us, where only the first frame tells it.
  /// Requires that no frame has been written. Fails  kUnavailable when the disk is full.
  Result<void> note_unix_zero(std::int64_t unix_zero_us);

  /// One depth picture, in the note's unit, of its size. `timestamp` is on the device's clock, at least 0 and
  /// not before that of the stream's last frame.
  /// Fails  kInvalid for a size, a time or a value beyond the largest, kUnsupported for a picture that the
  ///        coding cannot hold, kUnavailable when the disk is full or the file as large as it may be. The frame
  ///        is then not in the file; the file is as it was.
  Result<void> write_depth(std::chrono::microseconds timestamp, const DepthImage& depth);

  /// One colour picture of the colour camera's size. Requires that the content has colour. Fails as write_depth().
  Result<void> write_color(std::chrono::microseconds timestamp, const ColorImage& color);

  /// One colour picture that is a JPEG file of the right size and three components already: its bytes go in
  /// unchanged. Requires ColorCoding::kJpeg.
  Result<void> write_jpeg(std::chrono::microseconds timestamp, std::span<const std::uint8_t> jpeg);

  /// Makes the file whole as it stands: should the program die, it plays up to here. Costs a hundred bytes of
  /// the file each time that frames have come since the last. Fails  kUnavailable when the disk is full.
  Result<void> checkpoint();

  /// Writes seek tables and counts and closes the file. Call it once, last. Where there is no room for seek
  /// tables the file goes without them: it plays as well. Fails  kUnavailable when the disk has no room at all.
  Result<void> finish();

  /// Instead of finish(): takes the file away again.
  void discard() { file_.discard(); }

  std::uint64_t bytes() const { return file_.size(); }

 private:
  struct Stream {
    std::uint32_t node = 0;  // 1 depth, 2 colour
    std::uint64_t added_position = 0, counts_position = 0;
    std::vector<FramePlace> frames;
  };

  OniWriter(std::string path, OniContent content, OutputFile file)
      : path_(std::move(path)), content_(std::move(content)), file_(std::move(file)) {}

  static Result<OniWriter> begin(const OniContent& content, Result<OutputFile> file);
  const CameraModel& camera_of(const Stream& stream) const;
  std::uint16_t largest_depth() const;
  void append_definition(RecordBytesOut& bytes, Stream& stream);
  Result<void> append_frame(Stream& stream, std::chrono::microseconds timestamp,
                            std::span<const std::uint8_t> payload);
  Result<void> end(SeekTables seek_tables);

  std::string path_;
  OniContent content_;
  OutputFile file_;
  std::vector<std::uint8_t> payload_;
  JpegEncoder jpeg_;
  std::vector<std::uint8_t> record_;
  Stream depth_{1, 0, 0, {}};
  Stream color_{2, 0, 0, {}};
  std::optional<std::uint64_t> end_at_;  // of the last checkpoint
  bool frames_since_ = false;            // ... and whether frames came after it
};

}  // namespace copresence::recording
