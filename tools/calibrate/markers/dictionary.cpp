#include "tools/calibrate/markers/dictionary.h"

#include <map>
#include <opencv2/aruco.hpp>

namespace copresence::calibrate {
namespace {

const std::map<std::string, int>& dictionaries() {
  static const std::map<std::string, int> kAll{
      {"4x4_50", cv::aruco::DICT_4X4_50},
      {"4x4_100", cv::aruco::DICT_4X4_100},
      {"5x5_50", cv::aruco::DICT_5X5_50},
      {"5x5_100", cv::aruco::DICT_5X5_100},
      {"6x6_50", cv::aruco::DICT_6X6_50},
      {"6x6_250", cv::aruco::DICT_6X6_250},
      {"7x7_50", cv::aruco::DICT_7X7_50},
      {"original", cv::aruco::DICT_ARUCO_ORIGINAL},
      {"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5},
      {"apriltag_25h9", cv::aruco::DICT_APRILTAG_25h9},
      {"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11},
  };
  return kAll;
}

}  // namespace

std::vector<std::string> marker_dictionaries() {
  std::vector<std::string> names;
  for (const auto& [name, number] : dictionaries()) names.push_back(name);
  return names;
}

std::optional<int> dictionary_number(const std::string& name) {
  const auto found = dictionaries().find(name);
  return found == dictionaries().end() ? std::nullopt : std::optional(found->second);
}

}  // namespace copresence::calibrate
