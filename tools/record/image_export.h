#pragma once

// Writes a recording as a folder of images, in a form that other programs for RGB-D data read. The
// command from-images makes the same recording of such a folder again.

#include <cstdint>
#include <string>
#include <vector>

#include "capture_server/recording/oni_repair.h"
#include "common/result.h"
#include "tools/record/settings.h"

namespace copresence::record {

struct ExportReport {
  std::size_t depth_images = 0, color_images = 0;
  std::vector<std::string> folders;  ///< One for each camera.
  std::vector<std::string> remarks;  ///< Messages for the user.
};

/// Exports an .oni recording into settings.out, or the cameras of a session recording (.mkv) into
/// folders of their names in it. Fails as OniReader::open() and SessionFile::open() do, with
/// kInvalid if a folder exists and is not empty, and with kUnavailable if writing fails.
Result<ExportReport> export_images(const ExportSettings& settings, const recording::ProgressReport& progress);

}  // namespace copresence::record
