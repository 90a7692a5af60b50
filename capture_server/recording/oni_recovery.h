#pragma once

// The tolerant parser of a recording. The parser finds every whole frame, even if the file is cut
// off or damaged. The strict parser is in oni_parser.h.
// Thread: free functions; concurrent calls are safe.

#include <cstdint>
#include <string>
#include <vector>

#include "capture_server/recording/record_append.h"
#include "capture_server/recording/record_bytes.h"
#include "common/result.h"

namespace copresence::recording {

struct RecoveredFrame {
  std::uint64_t timestamp_us = 0, position = 0;
  std::uint32_t number = 0, fields_bytes = 0, payload_bytes = 0;

  std::uint64_t bytes() const { return std::uint64_t{fields_bytes} + payload_bytes; }
};

struct RecoveredStream {
  std::uint32_t node = 0;
  NodeType type{};
  std::uint64_t added_position = 0;    ///< Position of its kNodeAdded.
  std::uint64_t counts_position = 0;   ///< Position of the last kNodeCountsBytes; 0 in an old file.
  std::vector<RecoveredFrame> frames;  ///< Frames in the file's order, with increasing numbers.

  std::vector<FramePlace> places() const;
};

/// A range of damaged bytes that belong to no record.
struct Gap {
  std::uint64_t from = 0, to = 0;
};

struct RecoveredRecording {
  bool is_old = false;                   ///< True for files of OpenNI 1.0 to 1.3, see oni_format.h.
  std::vector<RecoveredStream> streams;  ///< All streams that may have frames, at least one.
  std::uint32_t largest_node = 0;
  std::uint64_t first_frame_position = 0;  ///< All streams are defined before this position in the file.
  std::uint64_t whole_until = 0;           ///< End of the last whole record.
  bool has_end = false;                    ///< True if the last whole record is a kEnd.
  bool has_seek_tables = false;
  std::uint64_t end_position = 0;      ///< Position of the footer that ends with this kEnd.
  std::vector<std::uint64_t> footers;  ///< Positions of all footers without seek tables.
  std::vector<Gap> gaps;               ///< Damage before whole_until.

  std::uint64_t frames() const;
  /// Number of frames of all streams of one type.
  std::uint64_t frames(NodeType type) const;
};

/// Searches a recording of `bytes.size()` bytes. `name` is the recording's name in messages.
/// Fails with kCorrupt or kUnsupported if no stream of a recording is defined in it.
Result<RecoveredRecording> recover(RecordBytes& bytes, const std::string& name);

}  // namespace copresence::recording
