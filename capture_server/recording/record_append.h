#pragma once

// Serialises the records of oni_format.h.
// Thread: free functions on values, safe anywhere.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "capture_server/recording/oni_format.h"

namespace copresence::recording {

using RecordBytesOut = std::vector<std::uint8_t>;

/// Appends the lowest `size` bytes of a number, little-endian.
void append_number(RecordBytesOut& bytes, std::uint64_t value, int size);

void append_text(RecordBytesOut& bytes, std::string_view text);

/// Appends a record's head and fields. The caller appends the payload of `payload_bytes` bytes.
void append_record(RecordBytesOut& bytes, RecordType type, std::uint32_t node,
                   std::span<const std::uint8_t> fields, std::size_t payload_bytes = 0,
                   std::uint64_t undo_position = 0);

void append_integer(RecordBytesOut& bytes, std::uint32_t node, std::string_view key, std::uint64_t value);
void append_general(RecordBytesOut& bytes, std::uint32_t node, std::string_view key,
                    std::span<const std::uint8_t> value);

/// Appends a kNewData's head and fields.
void append_frame_head(RecordBytesOut& bytes, std::uint32_t node, std::uint64_t timestamp_us,
                       std::uint32_t number, std::size_t payload_bytes, std::uint64_t undo_position);

/// Returns a recording's first 24 bytes.
RecordBytesOut file_header(std::uint64_t largest_timestamp, std::uint32_t largest_node);

struct FramePlace {
  std::uint64_t timestamp_us = 0, position = 0;
  friend bool operator==(const FramePlace&, const FramePlace&) = default;
};

/// Appends a stream's kNodeAdded, with no frames yet.
void append_node_added(RecordBytesOut& bytes, std::uint32_t node, std::string_view name, NodeType type,
                       std::uint32_t codec);

/// The last bytes of a kNodeAdded: the number of frames, their first and last time, and the
/// position of the seek table. The function returns these bytes for the given frames.
inline constexpr std::size_t kNodeCountsBytes = 28;
RecordBytesOut node_counts(std::span<const FramePlace> frames, std::uint64_t seek_table_position);

/// Appends a stream's kSeekTable.
void append_seek_table(RecordBytesOut& bytes, std::uint32_t node, std::span<const FramePlace> frames);

}  // namespace copresence::recording
