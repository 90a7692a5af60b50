#pragma once

// Rendered pictures and depth images of planes, for any camera model: boards and markers at known
// poses.

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"
#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {

/// The plane z = 0 of its own frame.
struct PaintedPlane {
  Rigid3 camera_from_plane;
  std::function<int(double x, double y)> gray;  ///< 0 to 255, or -1 outside of the plane; x and y in metres.
};

class PaintedCamera {
 public:
  static constexpr int kBackground = 120;

  explicit PaintedCamera(const CameraModel& model) : model_(model) {
    for (int y = 0; y < model.height; ++y) {
      for (int x = 0; x < model.width; ++x) {
        for (const double dy : {-0.25, 0.25}) {
          for (const double dx : {-0.25, 0.25}) rays_.push_back(unproject(model, {x + dx, y + dy}, 1));
        }
      }
    }
  }

  ColorImage picture(const std::vector<PaintedPlane>& planes) const {
    ColorImage out(model_.width, model_.height);
    for (std::size_t i = 0; i < out.pixels().size(); ++i) {
      int sum = 0;
      for (std::size_t s = 0; s < 4; ++s) sum += look(planes, rays_[4 * i + s]).gray;
      const auto gray = static_cast<std::uint8_t>(sum / 4);
      out.data()[i] = {gray, gray, gray};
    }
    return out;
  }

  /// Depth in millimetres. Black has no depth. There is a wall at 3 m.
  DepthImage depth(const std::vector<PaintedPlane>& planes) const {
    DepthImage out(model_.width, model_.height);
    for (std::size_t i = 0; i < out.pixels().size(); ++i) {
      const Hit hit = look(planes, 0.5 * (rays_[4 * i] + rays_[4 * i + 3]));
      out.data()[i] = hit.gray < 60 ? std::uint16_t{0} : static_cast<std::uint16_t>(1000 * hit.z + 0.5);
    }
    return out;
  }

 private:
  struct Hit {
    int gray = kBackground;
    double z = 3;
  };

  static Hit look(const std::vector<PaintedPlane>& planes, const Eigen::Vector3d& ray) {
    Hit nearest;
    for (const PaintedPlane& plane : planes) {
      const Eigen::Vector3d normal = plane.camera_from_plane.rotation.col(2);
      const double z = normal.dot(plane.camera_from_plane.translation) / normal.dot(ray);
      if (!(z > 0) || z > nearest.z) continue;
      const Eigen::Vector3d at = plane.camera_from_plane.inverse() * (z * ray);
      const int gray = plane.gray(at.x(), at.y());
      if (gray >= 0) nearest = {gray, z};
    }
    return nearest;
  }

  CameraModel model_;
  std::vector<Eigen::Vector3d> rays_;  // four per pixel
};

/// A marker of DICT_4X4_50 with a white rim of a cell.
inline constexpr double kMarkerSize = 0.24;  // metres, of the black square.
inline PaintedPlane painted_marker(int id, const Rigid3& camera_from_marker) {
  return {camera_from_marker, [bits = marker_cells("4x4_50", id, 1)](double x, double y) {
            const double u = (x / kMarkerSize + 0.5) * 6, v = (y / kMarkerSize + 0.5) * 6;
            if (u < -1 || v < -1 || u > 7 || v > 7) return -1;
            if (u < 0 || v < 0 || u >= 6 || v >= 6) return 230;
            return bits.at<uchar>(int(v), int(u)) > 127 ? 230 : 20;
          }};
}

/// Poses of five markers, some decimetres apart, 1.2 to 1.7 m in front of the camera.
inline std::vector<Rigid3> marker_places() {
  const auto at = [](double x, double y, double z, double yaw, double pitch) {
    return Rigid3{(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix(),
                  {x, y, z}};
  };
  return {at(-0.45, -0.28, 1.3, 0.3, 0.1), at(0.35, -0.3, 1.2, -0.2, 0.2), at(0.05, 0.05, 1.7, 0.1, -0.3),
          at(-0.4, 0.3, 1.25, 0.2, -0.2), at(0.5, 0.3, 1.6, -0.4, 0.1)};
}
inline std::vector<PaintedPlane> painted_markers(const Rigid3& camera_from_first) {
  std::vector<PaintedPlane> all;
  for (const Rigid3& place : marker_places()) {
    all.push_back(painted_marker(int(all.size()), camera_from_first * place));
  }
  return all;
}

}  // namespace copresence::calibrate
