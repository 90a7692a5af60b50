#include "capture_server/recording/record_append.h"

namespace copresence::recording {
namespace {

using Bytes = RecordBytesOut;

void append_u32(Bytes& bytes, std::uint64_t value) {
  append_number(bytes, value, 4);
}
void append_u64(Bytes& bytes, std::uint64_t value) {
  append_number(bytes, value, 8);
}

}  // namespace

void append_number(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

void append_text(Bytes& bytes, std::string_view text) {
  append_u32(bytes, text.size() + 1);
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.push_back(0);
}

void append_record(Bytes& bytes, RecordType type, std::uint32_t node, std::span<const std::uint8_t> fields,
                   std::size_t payload_bytes, std::uint64_t undo_position) {
  append_u32(bytes, kRecordMagic);
  append_u32(bytes, static_cast<std::uint32_t>(type));
  append_u32(bytes, node);
  append_u32(bytes, kRecordBytes + fields.size());
  append_u32(bytes, payload_bytes);
  append_u64(bytes, undo_position);
  bytes.insert(bytes.end(), fields.begin(), fields.end());
}

void append_integer(Bytes& bytes, std::uint32_t node, std::string_view key, std::uint64_t value) {
  Bytes fields;
  append_text(fields, key);
  append_u32(fields, 8);
  append_u64(fields, value);
  append_record(bytes, RecordType::kIntProperty, node, fields);
}

void append_general(Bytes& bytes, std::uint32_t node, std::string_view key,
                    std::span<const std::uint8_t> value) {
  Bytes fields;
  append_text(fields, key);
  append_u32(fields, value.size());
  fields.insert(fields.end(), value.begin(), value.end());
  append_record(bytes, RecordType::kGeneralProperty, node, fields);
}

void append_frame_head(Bytes& bytes, std::uint32_t node, std::uint64_t timestamp_us, std::uint32_t number,
                       std::size_t payload_bytes, std::uint64_t undo_position) {
  Bytes fields;
  append_u64(fields, timestamp_us);
  append_u32(fields, number);
  append_record(bytes, RecordType::kNewData, node, fields, payload_bytes, undo_position);
}

Bytes file_header(std::uint64_t largest_timestamp, std::uint32_t largest_node) {
  Bytes bytes(std::begin(kFileMagic), std::end(kFileMagic));
  append_number(bytes, 1, 1);
  append_number(bytes, 0, 1);
  append_number(bytes, 1, 2);
  append_u32(bytes, 0);
  append_u64(bytes, largest_timestamp);
  append_u32(bytes, largest_node);
  return bytes;
}

void append_node_added(Bytes& bytes, std::uint32_t node, std::string_view name, NodeType type,
                       std::uint32_t codec) {
  Bytes fields;
  append_text(fields, name);
  append_u32(fields, static_cast<std::uint32_t>(type));
  append_u32(fields, codec);
  const Bytes counts = node_counts({}, 0);
  fields.insert(fields.end(), counts.begin(), counts.end());
  append_record(bytes, RecordType::kNodeAdded, node, fields);
}

Bytes node_counts(std::span<const FramePlace> frames, std::uint64_t seek_table_position) {
  Bytes bytes;
  append_u32(bytes, frames.size());
  append_u64(bytes, frames.empty() ? 0 : frames.front().timestamp_us);
  append_u64(bytes, frames.empty() ? 0 : frames.back().timestamp_us);
  append_u64(bytes, seek_table_position);
  return bytes;
}

void append_seek_table(Bytes& bytes, std::uint32_t node, std::span<const FramePlace> frames) {
  append_record(bytes, RecordType::kSeekTable, node, {}, (frames.size() + 1) * kSeekEntryBytes);
  bytes.resize(bytes.size() + kSeekEntryBytes, 0);
  for (const FramePlace& frame : frames) {
    append_u64(bytes, frame.timestamp_us);
    append_u32(bytes, 0);
    append_u64(bytes, frame.position);
  }
}

}  // namespace copresence::recording
