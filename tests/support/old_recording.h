#pragma once

// Converts a recording to the format of OpenNI 1.0 to 1.3.

#include <cstdint>
#include <map>
#include <vector>

#include "tests/support/recording_scene.h"

namespace copresence::test {

/// `build` is 4, 5 or 6 and stands for version 1.0.0.`build`. Seek tables are left out, because
/// those recorders did not always write them.
inline std::vector<std::uint8_t> as_old_version(const std::vector<std::uint8_t>& bytes, std::uint32_t build) {
  using recording::RecordType;
  constexpr std::size_t kUndoBytes = 8, kCountsBytes = 28, kSeekPositionBytes = 8;
  std::vector<std::uint8_t> old(bytes.begin(), bytes.begin() + recording::kHeaderBytes);
  old[6] = 0;
  set_number_at(old, 8, build);
  std::map<std::uint32_t, std::vector<std::uint8_t>> counts;
  const auto append = [&](const auto& more) { old.insert(old.end(), more.begin(), more.end()); };
  for (const RecordPlace& record : records_of(bytes)) {
    if (record.type == RecordType::kSeekTable) continue;
    RecordType type = record.type;
    const std::size_t head = recording::kRecordBytes;
    std::vector<std::uint8_t> fields(bytes.begin() + static_cast<std::ptrdiff_t>(record.at + head),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(record.payload_at));
    if (type == RecordType::kNodeAdded) {
      counts[record.node].assign(fields.end() - static_cast<std::ptrdiff_t>(kCountsBytes), fields.end());
      const auto left_out = static_cast<std::ptrdiff_t>(build == 4 ? kCountsBytes : kSeekPositionBytes);
      fields.erase(fields.end() - left_out, fields.end());
      if (build == 4) type = RecordType::kNodeAddedOld;
      if (build == 5) type = RecordType::kNodeAddedOlder;
      if (build == 6) fields.insert(fields.end(), 4, std::uint8_t{0});
    }
    if (type == RecordType::kDataBegin && build == 4) {
      const auto& count = counts[record.node];  // Frames, first and last time, and seek table.
      fields.assign(count.begin(), count.begin() + 4);
      fields.insert(fields.end(), count.begin() + 12, count.begin() + 20);
    }
    std::vector<std::uint8_t> out(bytes.begin() + static_cast<std::ptrdiff_t>(record.at),
                                  bytes.begin() + static_cast<std::ptrdiff_t>(record.at + head - kUndoBytes));
    out.insert(out.end(), 4, std::uint8_t{0});
    set_number_at(out, 4, static_cast<std::uint32_t>(type));
    set_number_at(out, 12, static_cast<std::uint32_t>(out.size() + fields.size()));
    append(out);
    append(fields);
    old.insert(old.end(), bytes.begin() + static_cast<std::ptrdiff_t>(record.payload_at),
               bytes.begin() + static_cast<std::ptrdiff_t>(record.end()));
  }
  return old;
}

}  // namespace copresence::test
