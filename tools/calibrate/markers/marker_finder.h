#pragma once

// Finds ArUco and AprilTag markers in pictures of a still scene. Thread: one thread per object.

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/result.h"
#include "tools/calibrate/markers/found_marker.h"

namespace copresence::calibrate {

class MarkerFinder {
 public:
  /// border_bits  width of the markers' black rim, in cells.
  /// Fails  kInvalid for a name that is not among marker_dictionaries() (dictionary.h).
  static Result<MarkerFinder> open(const std::string& dictionary, int border_bits = 1);

  /// Looks for markers in one more picture; all must have the same size.
  void add(const ColorImage& picture);
  void add_gray(const Image<std::uint8_t>& picture);

  int pictures() const { return pictures_; }

  /// Markers seen in at least a third of the pictures, each corner where it lies in the median; those that lay within
  /// `kStill` pixels all the time. The middle is where the diagonals cross without the lens's distortion.
  std::vector<FoundMarker> found(const CameraModel& model) const;

  /// Those that moved.
  std::vector<std::string> moved() const;

  static constexpr double kStill = 2.5;  ///< pixels, from the median

 private:
  using Corners = std::array<Eigen::Vector2d, 4>;

  MarkerFinder(int dictionary, int border_bits) : dictionary_(dictionary), border_bits_(border_bits) {}
  bool is_still(const std::vector<Corners>& sightings) const;

  int dictionary_, border_bits_;
  int pictures_ = 0;
  std::map<int, std::vector<Corners>> seen_;  // by id
};

}  // namespace copresence::calibrate
