#pragma once

// Reads a session recording that SessionWriter wrote, or a copy of it by a program that keeps track
// names and attachments. The file is not trusted. Thread: one thread opens a file; concurrent
// read() calls are safe.

#include <optional>
#include <string>
#include <vector>

#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/matroska/reader.h"
#include "common/result.h"

namespace copresence::session {

using matroska::Time;

struct RecordedFrame {
  matroska::BlockPlace depth;
  std::optional<matroska::BlockPlace> color;

  Time time() const { return depth.time; }
  bool is_keyframe() const { return depth.is_keyframe; }
};

/// The frames of one description. The first frame is a keyframe. Times rise.
struct RecordedStream {
  StreamDescription description;
  std::vector<RecordedFrame> frames;  ///< Never empty.

  Time begin() const { return frames.front().time(); }
  Time end() const { return frames.back().time(); }
};

/// The streams of one camera in the order of their times. A camera has more than one stream if its
/// description changed during the session.
struct RecordedCamera {
  std::string name;
  std::vector<RecordedStream> streams;  ///< Never empty.
};

class SessionFile {
 public:
  /// Fails as matroska::Reader::open() does, and with kCorrupt if the file has no stream that can
  /// be replayed.
  static Result<SessionFile> open(const std::string& path);

  const std::vector<RecordedCamera>& cameras() const { return cameras_; }
  Time begin() const { return begin_; }  ///< The time of the first frame of any camera.
  Time end() const { return end_; }      ///< The time of the last frame of any camera.

  /// Sentences for the log about parts of the file that cannot be replayed.
  const std::vector<std::string>& remarks() const { return remarks_; }

  /// Returns the access units. Fails with kCorrupt if they are damaged, and with kUnavailable if
  /// the disk fails.
  Result<EncodedFrame> read(const RecordedFrame& frame) const;

 private:
  SessionFile(std::string path, matroska::Reader file) : path_(std::move(path)), file_(std::move(file)) {}
  /// Returns the stream that the attachment describes, or nothing and adds a remark.
  std::optional<RecordedStream> read_stream(const matroska::Attachment& attachment);
  std::optional<std::size_t> find_track(const std::string& name) const;
  std::vector<RecordedFrame> pair_frames(std::size_t depth, std::optional<std::size_t> color) const;
  void add_to_camera(RecordedStream stream);

  std::string path_;
  matroska::Reader file_;
  std::vector<RecordedCamera> cameras_;
  Time begin_{}, end_{};
  std::vector<std::string> remarks_;
};

}  // namespace copresence::session
