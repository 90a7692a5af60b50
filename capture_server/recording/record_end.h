#pragma once

// The end of a recording's file, written so that the file is whole at every moment: a program may be killed
// between any two writes, and the recording plays up to its last end.
//
// An end without seek tables is a mark that frames may follow: they are written behind it, then the next end,
// and only then does the old one become a property that every player skips. So the file costs a hundred bytes
// an end more, and no frame that an end has covered is ever lost.
//
// Thread: free functions, one thread per file.

#include <cstdint>
#include <span>
#include <vector>

#include "capture_server/recording/output_file.h"
#include "capture_server/recording/record_append.h"
#include "common/result.h"

namespace copresence::recording {

struct EndedStream {
  std::uint32_t node = 0;
  std::uint64_t added_position = 0;         ///< of its kNodeAdded
  std::uint64_t counts_position = 0;        ///< of that record's last kNodeCountsBytes
  std::span<const FramePlace> frames = {};  ///< all of them
};

enum class SeekTables { kNo, kYes };

/// Appends the end of these streams, at least one, and makes it the file's: counts, times and, where wanted,
/// seek tables are found from the front. `earlier_ends` are the positions of ends without seek tables of the
/// same streams, which lie before some frames.
/// Returns the new end's position.
/// Fails  as OutputFile; the file then still ends where it did.
Result<std::uint64_t> write_end(OutputFile& file, std::span<const EndedStream> streams,
                                SeekTables seek_tables, std::span<const std::uint64_t> earlier_ends);

/// Bytes of an end without seek tables.
constexpr std::uint64_t end_bytes(std::size_t streams) {
  return kRecordBytes * (streams + 1);
}

}  // namespace copresence::recording
