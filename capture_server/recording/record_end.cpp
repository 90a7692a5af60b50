#include "capture_server/recording/record_end.h"

#include <algorithm>
#include <cassert>

namespace copresence::recording {
namespace {

// What an end becomes when frames follow it: one property as long as its records.
RecordBytesOut skipped_end(std::uint32_t node, std::uint64_t size) {
  RecordBytesOut bytes;
  append_general(bytes, node, kFormerEndProperty, {});
  const RecordBytesOut filling(size - bytes.size(), 0);
  bytes.clear();
  append_general(bytes, node, kFormerEndProperty, filling);
  return bytes;
}

Result<void> write_counts(OutputFile& file, std::span<const EndedStream> streams,
                          std::span<const std::uint64_t> seek_tables) {
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const RecordBytesOut counts = node_counts(streams[i].frames, seek_tables.empty() ? 0 : seek_tables[i]);
    if (auto written = file.write_at(streams[i].counts_position, counts); !written) return written;
  }
  return {};
}

}  // namespace

Result<std::uint64_t> write_end(OutputFile& file, std::span<const EndedStream> streams,
                                SeekTables seek_tables, std::span<const std::uint64_t> earlier_ends) {
  assert(!streams.empty());
  const std::uint64_t end_at = file.size();
  RecordBytesOut bytes;
  std::vector<std::uint64_t> tables_at;
  std::uint64_t largest_timestamp = 0;
  for (const EndedStream& stream : streams) {
    append_record(bytes, RecordType::kNodeRemoved, stream.node, {}, 0, stream.added_position);
    if (seek_tables == SeekTables::kYes) {
      tables_at.push_back(end_at + bytes.size());
      append_seek_table(bytes, stream.node, stream.frames);
    }
    for (const FramePlace& frame : stream.frames)
      largest_timestamp = std::max(largest_timestamp, frame.timestamp_us);
  }
  append_record(bytes, RecordType::kEnd, 0, {});
  if (auto written = file.append(bytes); !written) return fail(written.error());

  // Counts and the largest time are upper bounds to the check and the player, so they may come before what
  // they count; a seek table must not be named before the way to it is open.
  if (auto written = write_counts(file, streams, {}); !written) return fail(written.error());
  RecordBytesOut largest;
  append_number(largest, largest_timestamp, 8);
  if (auto written = file.write_at(kHeaderTimestampAt, largest); !written) return fail(written.error());
  for (const std::uint64_t earlier : earlier_ends) {
    const auto skipped = skipped_end(streams.front().node, end_bytes(streams.size()));
    if (auto written = file.write_at(earlier, skipped); !written) return fail(written.error());
  }
  if (auto written = write_counts(file, streams, tables_at); !written) return fail(written.error());
  return end_at;
}

}  // namespace copresence::recording
