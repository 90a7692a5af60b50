#pragma once

// What of a recording is whole, however its file ends or is damaged: for repairing and cutting. Where check() asks
// whether OpenNI2 can play a file as it is, this looks for every whole frame.
//
// Thread: free functions; concurrent calls are safe.

#include <cstdint>
#include <string>
#include <vector>

#include "capture_server/recording/record_append.h"
#include "capture_server/recording/record_bytes.h"
#include "common/result.h"

namespace copresence::recording {

struct SalvagedFrame {
  std::uint64_t timestamp_us = 0, position = 0;
  std::uint32_t number = 0, fields_bytes = 0, payload_bytes = 0;

  std::uint64_t bytes() const { return std::uint64_t{fields_bytes} + payload_bytes; }
};

struct SalvagedStream {
  std::uint32_t node = 0;
  NodeType type{};
  std::uint64_t added_position = 0;   ///< of its kNodeAdded
  std::uint64_t counts_position = 0;  ///< of that record's last kNodeCountsBytes; 0 in a file that is_old
  std::vector<SalvagedFrame> frames;  ///< in the file's order, numbers rising

  std::vector<FramePlace> places() const;
};

/// Bytes that are no record.
struct Gap {
  std::uint64_t from = 0, to = 0;
};

struct Salvage {
  bool is_old = false;                  ///< of OpenNI 1.0 to 1.3, see oni_format.h
  std::vector<SalvagedStream> streams;  ///< at least one; those that may have frames
  std::uint32_t largest_node = 0;
  std::uint64_t first_frame_position = 0;  ///< the streams' definitions lie before it
  std::uint64_t whole_until = 0;           ///< where the last whole record ends
  bool has_end = false;                    ///< ... and it is an end, with seek tables where `has_seek_tables`
  bool has_seek_tables = false;
  std::uint64_t end_position = 0;   ///< where that end begins
  std::vector<std::uint64_t> ends;  ///< positions of ends without seek tables, all of them
  std::vector<Gap> gaps;            ///< damage before whole_until

  std::uint64_t frames() const;
  /// Of the streams of one type.
  std::uint64_t frames(NodeType type) const;
};

/// Looks through a recording of `bytes.size()` bytes; `name` stands for it in sentences.
/// Fails  kCorrupt, kUnsupported: not a recording, or so early damaged that no stream is defined.
Result<Salvage> salvage(RecordBytes& bytes, const std::string& name);

}  // namespace copresence::recording
