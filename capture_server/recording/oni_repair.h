#pragma once

// Makes recordings whole that were cut off, and shorter ones of whole ones. Frames are moved as they are coded: no
// picture changes.
//
// Thread: free functions; one call per file at a time.

#include <cstdint>
#include <functional>
#include <string>

#include "capture_server/recording/output_file.h"
#include "common/result.h"

namespace copresence::recording {

/// Called now and then with the share of the work that is done, 0 to 1.
using ProgressReport = std::function<void(double)>;

struct RepairReport {
  bool was_whole = false;                                                 ///< there was nothing to do
  std::uint64_t depth_frames = 0, color_frames = 0, infrared_frames = 0;  ///< now
  std::uint64_t dropped_bytes = 0;  ///< of an incomplete record at the end
  std::uint64_t gaps = 0;           ///< damaged places in the middle that are passed over now
};

/// Finishes a recording whose recorder was stopped: drops the incomplete record at its end, keeps every whole frame,
/// writes counts, times, seek tables and end. In place where `out` is empty, else into a copy there. Nothing is
/// changed before the whole file has been looked through, and a whole recording is left as it is.
/// Damage in the middle is passed over only in a copy; a recording of OpenNI 1.0 to 1.3 is finished only as a copy in
/// today's format.
/// Fails  kNotFound, kCorrupt (nothing to save, or a copy is needed and `out` is empty), kInvalid (`out` exists, with
///        kKeep), kUnavailable (disk).
Result<RepairReport> repair(const std::string& path, const std::string& out, Existing existing,
                            const ProgressReport& progress);

struct CutReport {
  std::uint64_t depth_frames = 0, color_frames = 0;
  double whole_s = 0;  ///< length of the whole recording: where the part ends at the latest
};

/// Writes the frames from `from_s` (included) to `to_s` (excluded), seconds after the first frame, into a recording
/// of their own at `out`, with their own times, so that the part knows when it began by the clock where the whole does.
/// `to_s` may lie beyond the end.
/// Fails  as check(); kInvalid where no depth frame lies there, or `out` exists with kKeep; kUnavailable (disk).
Result<CutReport> cut(const std::string& path, double from_s, double to_s, const std::string& out,
                      Existing existing, const ProgressReport& progress);

}  // namespace copresence::recording
