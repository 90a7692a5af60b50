#pragma once

// Completes recordings that were cut off, and cuts parts out of recordings. Frames are copied
// without decoding, so no picture changes.
// Thread: free functions; one call per file at a time.

#include <cstdint>
#include <functional>
#include <string>

#include "common/file/output_file.h"
#include "common/result.h"

namespace copresence::recording {

/// A function that is called repeatedly with the completed share of the work, from 0 to 1.
using ProgressReport = std::function<void(double)>;

struct RepairReport {
  bool was_whole = false;                                                 ///< True if nothing had to be done.
  std::uint64_t depth_frames = 0, color_frames = 0, infrared_frames = 0;  ///< Frames after the repair.
  std::uint64_t dropped_bytes = 0;  ///< Size of the incomplete record that was removed at the end.
  std::uint64_t gaps = 0;           ///< Number of damaged places in the middle that were skipped.
};

/// Completes a recording whose recorder was stopped. The function removes the incomplete record at
/// the end, keeps every whole frame, and writes counts, times, seek tables and footer. The work is
/// done in place if `out` is empty, else on a copy at `out`. The whole file is read before anything
/// is changed. A complete recording stays as it is. Damage in the middle is skipped only in a copy.
/// A recording of OpenNI 1.0 to 1.3 is completed only as a copy in the current format.
/// Fails with kNotFound if the file does not exist. Fails with kCorrupt if nothing can be saved, or
/// if a copy is needed and `out` is empty. Fails with kInvalid if `out` exists and `existing` is
/// kKeep. Fails with kUnavailable if the disk fails.
Result<RepairReport> repair(const std::string& path, const std::string& out, file::Existing existing,
                            const ProgressReport& progress);

struct CutReport {
  std::uint64_t depth_frames = 0, color_frames = 0;
  double whole_s = 0;  ///< Length of the whole recording in seconds.
};

/// Writes the frames from `from_s` (included) to `to_s` (excluded) into a new recording at `out`.
/// `from_s` and `to_s` are seconds after the first frame, and `to_s` may be beyond the end. The
/// frames keep their times, and the part keeps the wall clock time of the recording's start.
/// Fails as check() does. Fails with kInvalid if that range has no depth frame, or if `out` exists
/// and `existing` is kKeep. Fails with kUnavailable if the disk fails.
Result<CutReport> cut(const std::string& path, double from_s, double to_s, const std::string& out,
                      file::Existing existing, const ProgressReport& progress);

}  // namespace copresence::recording
