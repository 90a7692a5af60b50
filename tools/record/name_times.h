#pragma once

// Finds the times of images from their file names, for folders without lists.
// Thread: free functions; concurrent calls are safe.

#include <filesystem>
#include <optional>
#include <vector>

#include "common/result.h"
#include "tools/record/image_list.h"
#include "tools/record/time_reading.h"

namespace copresence::record {

struct NamedTimes {
  std::vector<ListedImage> images;
  TimeScale scale;
};

/// Finds the times of the images of one stream. A name may contain several numbers, such as
/// "0000012-000000366000". A time has precedence over a frame number, and of several frame numbers
/// the last one is used. Dates are UTC. If no number changes from name to name, the order of the
/// names gives frame numbers. `unit` is recognised if not given.
/// Fails with kInvalid if recognise_times() cannot decide.
Result<NamedTimes> times_of_names(const std::vector<std::filesystem::path>& paths,
                                  std::optional<TimeUnit> unit, double frames_per_second);

}  // namespace copresence::record
