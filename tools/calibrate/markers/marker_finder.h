#pragma once

// Finds ArUco and AprilTag markers in pictures of a still scene. Thread: one thread per object.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibrate {

/// A marker in a picture, found by a MarkerFinder or clicked by a person.
struct FoundMarker {
  std::string name;
  Eigen::Vector2d middle{0, 0};          ///< Centre, pixels.
  std::vector<Eigen::Vector2d> corners;  ///< Corner pixels, clockwise from the top left; empty if clicked.
  double sigma_px = 0.25;                ///< Expected standard deviation of each coordinate.
};

class MarkerFinder {
 public:
  /// `border_bits` is the width of the markers' black border, in cells.
  /// Fails with kInvalid for a name that is not in marker_dictionaries() (dictionary.h).
  static Result<MarkerFinder> open(const std::string& dictionary, int border_bits = 1);

  /// Searches one more picture. All pictures must have the same size.
  void add(const ColorImage& picture);
  void add_gray(const Image<std::uint8_t>& picture);

  int pictures() const { return pictures_; }

  /// Returns the still markers that at least a third of the pictures show. A marker is still if its
  /// corners stay within `kStill` of their median. Corners are medians over the pictures. The
  /// centre is where the diagonals cross after undistortion.
  std::vector<FoundMarker> found(const CameraModel& model) const;

  /// Names of the markers that moved.
  std::vector<std::string> moved() const;

  static constexpr double kStill = 2.5;  ///< Largest distance of a corner from its median, pixels.

 private:
  using Corners = std::array<Eigen::Vector2d, 4>;

  MarkerFinder(std::string dictionary, int border_bits)
      : dictionary_(std::move(dictionary)), border_bits_(border_bits) {}
  bool is_still(const std::vector<Corners>& observations) const;

  std::string dictionary_;
  int border_bits_;
  int pictures_ = 0;
  std::map<int, std::vector<Corners>> seen_;
};

/// Refines the corners (pixels, in order) of a dark square on white to 0.1 to 0.2 pixels, also at
/// grazing angles. Fits a line to the edge of each side; the corners are where these lines cross.
/// Detectors that look only around each corner err by several pixels at such angles. Returns false,
/// with invalid corners, if it does not find four edges near them.
bool refine_outline(const Image<std::uint8_t>& picture, std::array<Eigen::Vector2d, 4>& corners);

}  // namespace copresence::calibrate
