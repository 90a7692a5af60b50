#include "capture_server/recording/oni_footer.h"

#include <algorithm>
#include <cassert>

namespace copresence::recording {
namespace {

// Returns a property that overwrites a former footer of the same size.
RecordBytesOut skipped_footer(std::uint32_t node, std::uint64_t size) {
  RecordBytesOut bytes;
  append_general(bytes, node, kFormerEndProperty, {});
  const RecordBytesOut filling(size - bytes.size(), 0);
  bytes.clear();
  append_general(bytes, node, kFormerEndProperty, filling);
  return bytes;
}

Result<void> write_counts(file::OutputFile& file, std::span<const FooterStream> streams,
                          std::span<const std::uint64_t> seek_tables) {
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const RecordBytesOut counts = node_counts(streams[i].frames, seek_tables.empty() ? 0 : seek_tables[i]);
    if (auto written = file.write_at(streams[i].counts_position, counts); !written) return written;
  }
  return {};
}

}  // namespace

Result<std::uint64_t> write_footer(file::OutputFile& file, std::span<const FooterStream> streams,
                                   SeekTables seek_tables, std::span<const std::uint64_t> earlier_footers) {
  assert(!streams.empty());
  const std::uint64_t end_at = file.size();
  RecordBytesOut bytes;
  std::vector<std::uint64_t> tables_at;
  std::uint64_t largest_timestamp = 0;
  for (const FooterStream& stream : streams) {
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

  // The order of writes matters. Readers treat frame counts and the largest timestamp as upper
  // bounds, so these may be written early. The position of a seek table may be written only after
  // the former footers have become properties.
  if (auto written = write_counts(file, streams, {}); !written) return fail(written.error());
  RecordBytesOut largest;
  append_number(largest, largest_timestamp, 8);
  if (auto written = file.write_at(kHeaderTimestampAt, largest); !written) return fail(written.error());
  for (const std::uint64_t earlier : earlier_footers) {
    const auto skipped = skipped_footer(streams.front().node, footer_bytes(streams.size()));
    if (auto written = file.write_at(earlier, skipped); !written) return fail(written.error());
  }
  if (auto written = write_counts(file, streams, tables_at); !written) return fail(written.error());
  return end_at;
}

}  // namespace copresence::recording
