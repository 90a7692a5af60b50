#pragma once

// The sets of markers that can be looked for, by name.

#include <optional>
#include <string>
#include <vector>

namespace copresence::calibrate {

/// 4x4_50, 5x5_100, 6x6_250, apriltag_36h11, ...
std::vector<std::string> marker_dictionaries();

/// OpenCV's number of one; nothing for another name.
std::optional<int> dictionary_number(const std::string& name);

}  // namespace copresence::calibrate
