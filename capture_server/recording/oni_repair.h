#pragma once

// Completes recordings that were cut off, and cuts parts out of recordings. Frames are copied
// without decoding, so no picture changes.
//
// Thread: free functions; one call per file at a time.

#include <cstdint>
#include <functional>
#include <string>

#include "capture_server/recording/output_file.h"
#include "common/result.h"

namespace copresence::recording {

/// Called repeatedly with the completed share of the work, 0 to 1.
using ProgressReport = std::function<void(double)>;

struct RepairReport {
  bool was_whole = false;                                                 ///< nothing had to be done
  std::uint64_t depth_frames = 0, color_frames = 0, infrared_frames = 0;  ///< now
  std::uint64_t dropped_bytes = 0;  ///< of an incomplete record at the end, removed
  std::uint64_t gaps = 0;           ///< damaged places in the middle, skipped
};

/// Completes a recording whose recorder was stopped: removes the incomplete record at its end,
/// keeps every whole frame, and writes counts, times, seek tables and footer. Works in place if
/// `out` is empty, else on a copy there. Nothing is changed before the whole file was read. A whole
/// recording is left as it is. Damage in the middle is skipped only in a copy. A recording of
/// OpenNI 1.0 to 1.3 is completed only as a copy in the current format.
/// Fails  kNotFound, kCorrupt (nothing to save, or a copy is needed and `out` is empty), kInvalid
///        (`out` exists, with kKeep), kUnavailable (disk).
Result<RepairReport> repair(const std::string& path, const std::string& out, Existing existing,
                            const ProgressReport& progress);

struct CutReport {
  std::uint64_t depth_frames = 0, color_frames = 0;
  double whole_s = 0;  ///< length of the whole recording, the latest end of a part
};

/// Writes the frames from `from_s` (included) to `to_s` (excluded), in seconds after the first
/// frame, into a new recording at `out`. They keep their times, and the part keeps the start by the
/// clock. `to_s` may be beyond the end.
/// Fails  as check(); kInvalid if it has no depth frame in that range, or `out` exists with kKeep;
///        kUnavailable (disk).
Result<CutReport> cut(const std::string& path, double from_s, double to_s, const std::string& out,
                      Existing existing, const ProgressReport& progress);

}  // namespace copresence::recording
