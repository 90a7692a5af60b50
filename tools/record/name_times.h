#pragma once

// The times of images from their names, where no list tells them.
//
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

/// One stream's images with their times. A name may hold several numbers, as "0000012-000000366000" does: the one that
/// is a time is taken before one that counts frames, and of several that count the last. Dates are read as UTC. Where
/// no number changes from name to name, images count by their order.
/// Fails  kInvalid: recognise_times() cannot decide.
Result<NamedTimes> times_of_names(const std::vector<std::filesystem::path>& paths,
                                  std::optional<TimeUnit> unit, double frames_per_second);

}  // namespace copresence::record
