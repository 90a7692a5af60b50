#pragma once

// The tolerant parser of a recording: finds every whole frame, however the file ends or is damaged.
// For repairing and cutting; the strict parser is oni_parser.h.
//
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
  std::uint64_t added_position = 0;    ///< of its kNodeAdded
  std::uint64_t counts_position = 0;   ///< of that record's last kNodeCountsBytes; 0 in a file that is_old
  std::vector<RecoveredFrame> frames;  ///< in the file's order, with increasing numbers

  std::vector<FramePlace> places() const;
};

/// Bytes that belong to no record.
struct Gap {
  std::uint64_t from = 0, to = 0;
};

struct RecoveredRecording {
  bool is_old = false;                   ///< of OpenNI 1.0 to 1.3, see oni_format.h
  std::vector<RecoveredStream> streams;  ///< at least one; all streams that may have frames
  std::uint32_t largest_node = 0;
  std::uint64_t first_frame_position = 0;  ///< the streams' definitions come before it
  std::uint64_t whole_until = 0;           ///< end of the last whole record
  bool has_end = false;  ///< whether that record is a kEnd, with seek tables if `has_seek_tables`
  bool has_seek_tables = false;
  std::uint64_t end_position = 0;      ///< position of that footer
  std::vector<std::uint64_t> footers;  ///< positions of all footers without seek tables
  std::vector<Gap> gaps;               ///< damage before whole_until

  std::uint64_t frames() const;
  /// Of the streams of one type.
  std::uint64_t frames(NodeType type) const;
};

/// Searches a recording of `bytes.size()` bytes. `name` is its name in messages.
/// Fails  kCorrupt, kUnsupported: not a recording, or damaged before the first stream is defined.
Result<RecoveredRecording> recover(RecordBytes& bytes, const std::string& name);

}  // namespace copresence::recording
