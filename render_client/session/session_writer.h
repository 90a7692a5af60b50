#pragma once

// Writes a session recording: the frames of all cameras as they were received, in one Matroska
// file. docs/internals/session_recording.md describes the file. A stream gets its tracks with its
// first frame, so cameras may join at any time. A camera that connects again continues its tracks,
// unless its stream description has changed. Then it gets new tracks.
//
// Thread: one thread at a time.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "common/bitstream/access_unit.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/matroska/writer.h"
#include "common/result.h"

namespace copresence::session {

class SessionWriter {
 public:
  /// Creates `path`, or `name-2.mkv` and so on if it exists. Time 0 of the recording is `began_at`,
  /// on this process's monotonic clock. Fails as OutputFile::create_numbered() does.
  static Result<SessionWriter> create(const std::string& path, Instant began_at);

  /// Appends a frame. `captured_at` is on this process's clock. `camera` is the number of the
  /// camera's connection. Fails with kUnavailable if the file cannot be written and with
  /// kUnsupported if it has no room for another stream: then call finish(). Fails with kCorrupt if
  /// the frame is no access unit, or if a stream does not begin with a keyframe.
  Result<void> write(std::size_t camera, const std::shared_ptr<const StreamDescription>& description,
                     const EncodedFrame& frame, Instant captured_at);

  /// Completes the file. Call it last. Fails as matroska::Writer::finish() does.
  Result<void> finish() { return file_.finish(); }

  const std::string& path() const { return file_.path(); }
  std::uint64_t bytes() const { return file_.bytes(); }
  std::uint64_t frames() const { return frames_; }
  Duration duration() const { return std::chrono::duration_cast<Duration>(file_.duration()); }

 private:
  struct Stream {
    std::size_t camera;
    std::shared_ptr<const StreamDescription> description;
    std::string label;
    std::optional<std::uint64_t> depth_track, color_track;
    matroska::Time next_time{};  // The earliest time of the next frame.
  };
  using Nals = std::span<const bitstream::Nal>;

  SessionWriter(matroska::Writer file, Instant began_at) : file_(std::move(file)), began_at_(began_at) {}

  Stream& stream(std::size_t camera, const std::shared_ptr<const StreamDescription>& description);
  std::string free_label(const std::string& camera) const;
  Result<void> add_depth_track(Stream& stream, Nals first);
  Result<void> add_color_track(Stream& stream, Nals first);

  matroska::Writer file_;
  Instant began_at_;
  std::deque<Stream> streams_;  // A deque, so that references stay valid.
  std::uint64_t frames_ = 0;
};

}  // namespace copresence::session
