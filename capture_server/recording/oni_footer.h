#pragma once

// Writes the footer of a recording's file so that the file is valid at every moment. The program
// may be killed between any two writes, and the recording still plays up to its last footer.
//
// A footer without seek tables is temporary: frames may be written after it, and then the next
// footer. Only after that, the former footer becomes a property, which every player skips. Each
// footer costs a hundred bytes, and no frame before a footer is ever lost.
//
// Thread: free functions; one thread at a time per file.

#include <cstdint>
#include <span>
#include <vector>

#include "capture_server/recording/record_append.h"
#include "common/file/output_file.h"
#include "common/result.h"

namespace copresence::recording {

struct FooterStream {
  std::uint32_t node = 0;
  std::uint64_t added_position = 0;         ///< Position of its kNodeAdded.
  std::uint64_t counts_position = 0;        ///< Position of the last kNodeCountsBytes of its kNodeAdded.
  std::span<const FramePlace> frames = {};  ///< All frames of the stream so far.
};

enum class SeekTables { kNo, kYes };

/// Appends a footer for `streams`, which must not be empty. The function then makes this footer
/// valid by writing counts, times and, if requested, positions of seek tables at the front of the
/// file. `earlier_footers` are the positions of these streams' former footers, all without seek
/// tables. Returns the new footer's position.
/// Fails as file::OutputFile does. The file then still ends with its former footer.
Result<std::uint64_t> write_footer(file::OutputFile& file, std::span<const FooterStream> streams,
                                   SeekTables seek_tables, std::span<const std::uint64_t> earlier_footers);

/// Size of a footer without seek tables.
constexpr std::uint64_t footer_bytes(std::size_t streams) {
  return kRecordBytes * (streams + 1);
}

}  // namespace copresence::recording
