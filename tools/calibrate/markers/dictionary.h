#pragma once

// The sets of markers that can be looked for, by name, and which of them a picture shows. Thread: pure functions.

#include <optional>
#include <string>
#include <vector>

#include "common/frame/image.h"

namespace copresence::calibrate {

/// 4x4_50, 5x5_100, 6x6_250, apriltag_36h11, ...: all that OpenCV knows.
std::vector<std::string> marker_dictionaries();

/// The name among marker_dictionaries() that is meant by `name`, which may be in the spelling of OpenCV (DICT_4X4_50) or of
/// AprilTag (tag36h11). Nothing for another name.
std::optional<std::string> canonical_dictionary(const std::string& name);

/// OpenCV's number of a dictionary; nothing for a name that is not among marker_dictionaries().
std::optional<int> dictionary_number(const std::string& name);

/// Markers of one dictionary in a picture.
struct SeenDictionary {
  std::string name;
  int border_bits = 1;  ///< width of the black rim, in cells; 2 in Kalibr's AprilTag boards
  int markers = 0;

  /// "12 markers of apriltag_36h11: give --dictionary apriltag_36h11".
  std::string in_words() const;
};

/// The dictionary of which the picture shows most markers. Nothing where it shows none for certain. Takes about a second
/// for a picture of 1280x960 pixels.
std::optional<SeenDictionary> seen_dictionary(const ColorImage& picture);

}  // namespace copresence::calibrate
