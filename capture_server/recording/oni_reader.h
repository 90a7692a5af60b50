#pragma once

// Reads the pictures of a recording by their index.
// Thread: one thread at a time.

#include <cstdint>
#include <string>
#include <vector>

#include "capture_server/recording/oni_check.h"
#include "common/file/input_file.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

class OniReader {
 public:
  /// Opens and checks the recording. Fails as check() does.
  static Result<OniReader> open(const std::string& path);

  const RecordingSummary& summary() const { return summary_; }
  std::uint64_t file_bytes() const { return file_.size(); }

  /// Returns a frame's coded bytes. Requires a stream of summary() and frame < stream.frames().
  Result<std::vector<std::uint8_t>> payload(const RecordedStream& stream, std::size_t frame) const;

  /// Returns a picture. Requires that the recording has a stream of that kind and frame < its
  /// frames(). Fails with kCorrupt if the picture's bytes are damaged.
  Result<DepthImage> depth(std::size_t frame) const;
  Result<ColorImage> color(std::size_t frame) const;

 private:
  OniReader(file::InputFile file, RecordingSummary summary)
      : file_(std::move(file)), summary_(std::move(summary)) {}

  file::InputFile file_;
  RecordingSummary summary_;
};

}  // namespace copresence::recording
