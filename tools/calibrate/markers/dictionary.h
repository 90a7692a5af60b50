#pragma once

// Dictionaries of ArUco and AprilTag markers, by name. Hides the differences between OpenCV 4.6 and
// 4.10. Where not stated otherwise, a name must be in marker_dictionaries().
// Thread: pure functions.

#include <opencv2/aruco.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/frame/image.h"

namespace copresence::calibrate {

/// All dictionaries of OpenCV: 4x4_50, 5x5_100, 6x6_250, apriltag_36h11, ...
std::vector<std::string> marker_dictionaries();

/// Converts OpenCV's names (DICT_4X4_50) and AprilTag's names (tag36h11) to those of
/// marker_dictionaries(). Returns nothing if there is no such dictionary.
std::optional<std::string> canonical_dictionary(const std::string& name);

cv::Ptr<cv::aruco::Dictionary> make_dictionary(const std::string& name);

/// Number of markers in a dictionary.
int markers_in(const std::string& dictionary);

/// The cells of a marker with its black border, one pixel per cell: 0 for black, 255 for white.
/// Requires a number below markers_in().
cv::Mat marker_cells(const std::string& dictionary, int number, int border_bits);

/// Markers of one dictionary in a picture.
struct FoundDictionary {
  std::string name;
  int border_bits = 1;  ///< Width of the black border, in cells; 2 for Kalibr's AprilTag boards.
  int markers = 0;

  /// Such as "12 markers of apriltag_36h11: give --dictionary apriltag_36h11".
  std::string in_words() const;
};

/// Returns the dictionary with most markers in the picture, or nothing if too few are found. Takes
/// about a second for a picture of 1280x960 pixels.
std::optional<FoundDictionary> find_dictionary(const ColorImage& picture);

}  // namespace copresence::calibrate
