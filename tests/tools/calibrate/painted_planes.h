#pragma once

// Pictures and depth images of painted planes through any lens: boards and markers with a known answer.

#include <array>
#include <functional>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"
#include "common/frame/rigid3.h"

namespace copresence::calibrate {

/// The plane z = 0 of its own frame.
struct PaintedPlane {
  Rigid3 camera_from_plane;
  std::function<int(double x, double y)> gray;  ///< 0 to 255, or -1 where the plane ends; metres
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

  /// Millimetres; black returns no depth. A wall stands at 3 m.
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

}  // namespace copresence::calibrate
