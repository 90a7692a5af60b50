#include "tools/calibrate/markers/dictionary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace copresence::calibrate {
namespace {

const std::map<std::string, int>& dictionaries() {
  static const std::map<std::string, int> kAll{
      {"4x4_50", cv::aruco::DICT_4X4_50},
      {"4x4_100", cv::aruco::DICT_4X4_100},
      {"4x4_250", cv::aruco::DICT_4X4_250},
      {"4x4_1000", cv::aruco::DICT_4X4_1000},
      {"5x5_50", cv::aruco::DICT_5X5_50},
      {"5x5_100", cv::aruco::DICT_5X5_100},
      {"5x5_250", cv::aruco::DICT_5X5_250},
      {"5x5_1000", cv::aruco::DICT_5X5_1000},
      {"6x6_50", cv::aruco::DICT_6X6_50},
      {"6x6_100", cv::aruco::DICT_6X6_100},
      {"6x6_250", cv::aruco::DICT_6X6_250},
      {"6x6_1000", cv::aruco::DICT_6X6_1000},
      {"7x7_50", cv::aruco::DICT_7X7_50},
      {"7x7_100", cv::aruco::DICT_7X7_100},
      {"7x7_250", cv::aruco::DICT_7X7_250},
      {"7x7_1000", cv::aruco::DICT_7X7_1000},
      {"original", cv::aruco::DICT_ARUCO_ORIGINAL},
      {"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5},
      {"apriltag_25h9", cv::aruco::DICT_APRILTAG_25h9},
      {"apriltag_36h10", cv::aruco::DICT_APRILTAG_36h10},
      {"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11},
  };
  return kAll;
}

// Dictionaries of increasing size that begin with the same markers: OpenCV's 4x4_50 has the first
// 50 markers of its 4x4_1000.
struct Family {
  const char* prefix;        // Beginning of the names, before the number of markers.
  std::array<int, 4> sizes;  // Numbers of markers; 0 if the prefix is the whole name.
  int fewest;                // Number of found markers that rules out chance.
};
constexpr std::array<Family, 9> kFamilies{{{"4x4_", {50, 100, 250, 1000}, 2},
                                           {"5x5_", {50, 100, 250, 1000}, 2},
                                           {"6x6_", {50, 100, 250, 1000}, 1},
                                           {"7x7_", {50, 100, 250, 1000}, 1},
                                           {"original", {}, 2},
                                           {"apriltag_16h5", {}, 3},
                                           {"apriltag_25h9", {}, 2},
                                           {"apriltag_36h10", {}, 1},
                                           {"apriltag_36h11", {}, 1}}};

std::string name_of(const Family& family, int highest_id) {
  if (family.sizes[0] == 0) return family.prefix;
  const auto size = std::find_if(family.sizes.begin(), family.sizes.end(),
                                 [&](int markers) { return markers > highest_id; });
  return fmt::format("{}{}", family.prefix, *size);
}

}  // namespace

std::vector<std::string> marker_dictionaries() {
  std::vector<std::string> names;
  for (const auto& [name, number] : dictionaries()) names.push_back(name);
  return names;
}

std::optional<std::string> canonical_dictionary(const std::string& name) {
  std::string text;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else {
      text += '_';
    }
  }
  const auto drop = [&](std::string_view prefix) {
    const bool has = text.starts_with(prefix);
    if (has) text.erase(0, prefix.size());
    return has;
  };
  drop("dict_");
  drop("aruco_");
  if (drop("apriltag") || drop("tag")) {
    drop("_");
    text = "apriltag_" + text;
  }
  return dictionaries().contains(text) ? std::optional(text) : std::nullopt;
}

// OpenCV 4.7 made dictionaries values instead of pointers, and renamed its drawing functions.
cv::Ptr<cv::aruco::Dictionary> make_dictionary(const std::string& name) {
  return cv::makePtr<cv::aruco::Dictionary>(cv::aruco::getPredefinedDictionary(dictionaries().at(name)));
}

int markers_in(const std::string& dictionary) {
  return make_dictionary(dictionary)->bytesList.rows;
}

cv::Mat marker_cells(const std::string& dictionary, int number, int border_bits) {
  const auto codes = make_dictionary(dictionary);
  const int cells = codes->markerSize + 2 * border_bits;
  cv::Mat bits;
#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 407
  cv::aruco::generateImageMarker(*codes, number, cells, bits, border_bits);
#else
  cv::aruco::drawMarker(codes, number, cells, bits, border_bits);
#endif
  return bits;
}

std::string FoundDictionary::in_words() const {
  const std::string many = fmt::format("{} marker{} of {}", markers, markers == 1 ? "" : "s", name);
  if (border_bits == 1) return fmt::format("{}: give --dictionary {}", many, name);
  return fmt::format("{} with a black border of {} cells: give --dictionary {} --border-bits {}", many,
                     border_bits, name, border_bits);
}

std::optional<FoundDictionary> find_dictionary(const ColorImage& picture) {
  constexpr int kLongerSide = 1280;  // Limits the search time.
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat gray;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  const double scale = static_cast<double>(kLongerSide) / std::max(gray.cols, gray.rows);
  if (scale < 1) cv::resize(gray, gray, {}, scale, scale, cv::INTER_AREA);
  std::optional<FoundDictionary> best;
  for (const int border_bits : {1, 2}) {
    const auto parameters = cv::makePtr<cv::aruco::DetectorParameters>();
    parameters->markerBorderBits = border_bits;
    for (const Family& family : kFamilies) {
      const std::string whole = name_of(family, 999);
      std::vector<std::vector<cv::Point2f>> corners;
      std::vector<int> ids;
      cv::aruco::detectMarkers(gray, make_dictionary(whole), corners, ids, parameters);
      const int markers = static_cast<int>(ids.size());
      if (markers < family.fewest || (best && markers <= best->markers)) continue;
      best =
          FoundDictionary{name_of(family, *std::max_element(ids.begin(), ids.end())), border_bits, markers};
    }
  }
  return best;
}

}  // namespace copresence::calibrate
