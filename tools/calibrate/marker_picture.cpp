#include "tools/calibrate/marker_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/picture_file.h"

namespace copresence::calibrate {
namespace {

constexpr int kWidest = 960;  // of the whole sheet where more than two cameras share it

const cv::Scalar kGood(80, 220, 80), kDoubtful(0, 220, 255), kBad(60, 60, 255);  // blue, green, red

cv::Point point(const Eigen::Vector2d& pixel) {
  return {cv::saturate_cast<int>(pixel.x()), cv::saturate_cast<int>(pixel.y())};
}

// scale  from the camera's pixels to those of the image.
void mark(cv::Mat& image, double scale, const FoundMarker& marker, const std::string& text,
          const cv::Scalar& color) {
  const Eigen::Vector2d middle = scale * marker.middle;
  double below = middle.y() + 10, left = middle.x() - 10;
  for (std::size_t i = 0; i < marker.corners.size(); ++i) {
    const Eigen::Vector2d corner = scale * marker.corners[i];
    const Eigen::Vector2d next = scale * marker.corners[(i + 1) % marker.corners.size()];
    cv::line(image, point(corner), point(next), color, 2, cv::LINE_AA);
    below = std::max(below, corner.y());
    left = std::min(left, corner.x());
  }
  cv::drawMarker(image, point(middle), color, cv::MARKER_CROSS, 8, 1, cv::LINE_AA);
  write_label(image, text, point({left, below + 14}), color);
}

}  // namespace

Result<void> write_marked_pictures(std::span<const MarkedPicture> cameras, const calibration::Names& names,
                                   std::span<const calibration::Sighting> sightings,
                                   const calibration::WorldFit& fit, const std::filesystem::path& file) {
  int width = 0, height = 0;
  for (const MarkedPicture& camera : cameras) {
    width = std::max(width, camera.picture.width());
    height = std::max(height, camera.picture.height());
  }
  const int count = static_cast<int>(cameras.size());
  // Many cameras are shown smaller, and the labels as large as ever.
  const double scale = count > 2 ? std::min(1.0, 0.5 * kWidest / width) : 1;
  const auto scaled = [scale](int pixels) { return static_cast<int>(std::lround(scale * pixels)); };
  width = scaled(width);
  height = scaled(height);
  cv::Mat all(height * ((count + 1) / 2), width * std::min(count, 2), CV_8UC3, cv::Scalar(0, 0, 0));
  for (int c = 0; c < count; ++c) {
    const MarkedPicture& camera = cameras[static_cast<std::size_t>(c)];
    const cv::Mat rgb(camera.picture.height(), camera.picture.width(), CV_8UC3,
                      const_cast<Rgb8*>(camera.picture.data()));
    cv::Mat here = all(cv::Rect(c % 2 * width, c / 2 * height, scaled(rgb.cols), scaled(rgb.rows)));
    cv::Mat smaller;
    cv::resize(rgb, smaller, here.size(), 0, 0, cv::INTER_AREA);
    cv::cvtColor(smaller, here, cv::COLOR_RGB2BGR);
    write_label(here, camera.camera, {8, 18}, {255, 255, 255});
    for (const FoundMarker& marker : camera.markers) {
      const auto depth = std::find_if(camera.depths.begin(), camera.depths.end(),
                                      [&](const MarkerDepth& d) { return d.marker == marker.name; });
      const auto sighting =
          std::find_if(sightings.begin(), sightings.end(), [&](const calibration::Sighting& s) {
            return s.camera == static_cast<std::size_t>(c) && s.part == 0 &&
                   names.markers[s.marker] == marker.name;
          });
      if (depth == camera.depths.end() || sighting == sightings.end()) {
        mark(here, scale, marker, marker.name + ": not used", kBad);
        continue;
      }
      if (fit.markers[sighting->marker].residual.count < 2) {
        mark(here, scale, marker, fmt::format("{}: {:.2f} m, no other camera", marker.name, depth->z_m),
             kDoubtful);
        continue;
      }
      const Eigen::Vector3d there =
          fit.cameras[sighting->camera].world_from_camera * sighting->point_in_camera();
      const double off_mm = 1000 * (there - fit.markers[sighting->marker].in_world).norm();
      mark(here, scale, marker, fmt::format("{}: {:.2f} m, {:.1f} mm", marker.name, depth->z_m, off_mm),
           off_mm <= 10   ? kGood
           : off_mm <= 30 ? kDoubtful
                          : kBad);
    }
  }
  return write_picture(all, file);
}

}  // namespace copresence::calibrate
