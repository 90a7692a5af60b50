#include "tools/calibrate/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/command_line/values.h"
#include "tools/calibrate/refinement/association.h"

namespace copresence::calibrate {
CLI::Validator picture_file_name() {
  return {[](const std::string& text) {
            const std::string kind = CLI::detail::to_lower(std::filesystem::path(text).extension().string());
            const bool is_picture = kind == ".png" || kind == ".jpg" || kind == ".jpeg";
            if (!text.empty() && !is_picture) {
              return fmt::format("\"{}\" is not a picture's name: end it with .png or .jpg", text);
            }
            std::string copy = text;
            return command_line::writable_file()(copy);
          },
          ""};
}

namespace {

const cv::Scalar kGood(80, 220, 80), kDoubtful(0, 220, 255), kBad(60, 60, 255), kWhite(255, 255, 255);  // BGR

cv::Point pixel_of(const Eigen::Vector2d& point) {
  return {cv::saturate_cast<int>(point.x()), cv::saturate_cast<int>(point.y())};
}

// `at` is the left end of the text's base line. The black rim makes text readable on any picture.
void write_label(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, color, 1, cv::LINE_AA);
}

Result<void> write_picture(const cv::Mat& picture, const std::filesystem::path& file) {
  if (cv::imwrite(file.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 80})) return {};
  return fail(ErrorCode::kUnavailable, fmt::format("{}: the picture cannot be written", file.string()));
}

cv::Mat mat_of(const ColorImage& picture) {
  return {picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data())};
}

}  // namespace

namespace {

constexpr int kTile = 240, kColumns = 4;  // Width of a tile in pixels; tiles per row.
constexpr std::size_t kMostTiles = 24;

}  // namespace

void BoardPictures::add(const BoardView& view, const ColorImage& picture) {
  const double scale = static_cast<double>(kTile) / picture.width();
  const cv::Mat all = mat_of(picture);
  Small small{ColorImage(kTile, static_cast<int>(scale * picture.height())), {}};
  cv::Mat scaled(small.picture.height(), kTile, CV_8UC3, small.picture.data());
  cv::resize(all, scaled, scaled.size(), 0, 0, cv::INTER_AREA);
  for (const Eigen::Vector2d& pixel : view.pixels) small.corners.push_back(scale * pixel);
  pictures_[view.picture] = std::move(small);
}

Result<void> BoardPictures::write(const IntrinsicsFit& fit, const std::filesystem::path& file) const {
  std::vector<ViewFit> views = fit.views;
  std::erase_if(views, [&](const ViewFit& view) { return !pictures_.contains(view.picture); });
  std::stable_sort(views.begin(), views.end(),
                   [](const ViewFit& a, const ViewFit& b) { return a.rms_px > b.rms_px; });
  views.resize(std::min(views.size(), kMostTiles - 1));
  const int height = kTile * fit.model.height / fit.model.width;
  const int tiles = static_cast<int>(views.size()) + 1;
  cv::Mat sheet(height * ((tiles + kColumns - 1) / kColumns), kTile * kColumns, CV_8UC3, cv::Scalar(0, 0, 0));
  const auto tile = [&](int number) {
    return sheet(cv::Rect(number % kColumns * kTile, number / kColumns * height, kTile, height));
  };
  cv::Mat covered = tile(tiles - 1);
  for (const ViewFit& view : fit.views) {
    const auto found = pictures_.find(view.picture);
    if (found == pictures_.end()) continue;
    for (const Eigen::Vector2d& corner : found->second.corners) {
      cv::circle(covered, pixel_of(corner), 1, kGood, cv::FILLED);
    }
  }
  for (int number = 0; number + 1 < tiles; ++number) {
    const ViewFit& view = views[static_cast<std::size_t>(number)];
    const auto found = pictures_.find(view.picture);
    if (found == pictures_.end()) continue;
    const Small& small = found->second;
    cv::Mat here = tile(number);
    const cv::Mat rgb = mat_of(small.picture);
    cv::cvtColor(rgb(cv::Rect(0, 0, kTile, std::min(height, rgb.rows))),
                 here(cv::Rect(0, 0, kTile, std::min(height, rgb.rows))), cv::COLOR_RGB2BGR);
    const cv::Scalar color = view.rms_px < 0.5 ? kGood : kBad;
    for (std::size_t i = 0; i < small.corners.size(); ++i) {
      if (i > 0)
        cv::line(here, pixel_of(small.corners[i - 1]), pixel_of(small.corners[i]), color, 1, cv::LINE_AA);
      cv::circle(here, pixel_of(small.corners[i]), 2, color, 1, cv::LINE_AA);
    }
    write_label(here, fmt::format("{}: {:.2f} px", view.picture, view.rms_px), {6, height - 8}, kWhite);
  }
  write_label(covered, fmt::format("covered: {:.0f} %", 100 * fit.covered), {6, height - 8}, kWhite);
  return write_picture(sheet, file);
}

namespace {

constexpr int kWidest = 960;  // Width of the sheet for more than two cameras, pixels.

// `scale` is the number of pixels of `image` per pixel of the camera.
void mark(cv::Mat& image, double scale, const FoundMarker& marker, const std::string& text,
          const cv::Scalar& color) {
  const Eigen::Vector2d middle = scale * marker.middle;
  double below = middle.y() + 10, left = middle.x() - 10;
  for (std::size_t i = 0; i < marker.corners.size(); ++i) {
    const Eigen::Vector2d corner = scale * marker.corners[i];
    const Eigen::Vector2d next = scale * marker.corners[(i + 1) % marker.corners.size()];
    cv::line(image, pixel_of(corner), pixel_of(next), color, 2, cv::LINE_AA);
    below = std::max(below, corner.y());
    left = std::min(left, corner.x());
  }
  cv::drawMarker(image, pixel_of(middle), color, cv::MARKER_CROSS, 8, 1, cv::LINE_AA);
  write_label(image, text, pixel_of({left, below + 14}), color);
}

}  // namespace

Result<void> write_marked_pictures(std::span<const MarkedPicture> cameras, const RigNames& names,
                                   std::span<const Observation> observations, const WorldFit& fit,
                                   const std::filesystem::path& file) {
  int width = 0, height = 0;
  for (const MarkedPicture& camera : cameras) {
    width = std::max(width, camera.picture.width());
    height = std::max(height, camera.picture.height());
  }
  const int count = static_cast<int>(cameras.size());
  // Pictures of many cameras are scaled down, but their labels are not.
  const double scale = count > 2 ? std::min(1.0, 0.5 * kWidest / width) : 1;
  const auto scaled = [scale](int pixels) { return static_cast<int>(std::lround(scale * pixels)); };
  width = scaled(width);
  height = scaled(height);
  cv::Mat all(height * ((count + 1) / 2), width * std::min(count, 2), CV_8UC3, cv::Scalar(0, 0, 0));
  for (int c = 0; c < count; ++c) {
    const MarkedPicture& camera = cameras[static_cast<std::size_t>(c)];
    const cv::Mat rgb = mat_of(camera.picture);
    cv::Mat here = all(cv::Rect(c % 2 * width, c / 2 * height, scaled(rgb.cols), scaled(rgb.rows)));
    cv::Mat smaller;
    cv::resize(rgb, smaller, here.size(), 0, 0, cv::INTER_AREA);
    cv::cvtColor(smaller, here, cv::COLOR_RGB2BGR);
    write_label(here, camera.camera, {8, 18}, {255, 255, 255});
    for (const FoundMarker& marker : camera.markers) {
      const auto depth = std::find_if(camera.depths.begin(), camera.depths.end(),
                                      [&](const MarkerDepth& d) { return d.marker == marker.name; });
      const auto observation =
          std::find_if(observations.begin(), observations.end(), [&](const Observation& s) {
            return s.camera == static_cast<std::size_t>(c) && s.part == 0 &&
                   names.markers[s.marker] == marker.name;
          });
      if (depth == camera.depths.end() || observation == observations.end()) {
        mark(here, scale, marker, marker.name + ": not used", kBad);
        continue;
      }
      if (fit.markers[observation->marker].residual.count < 2) {
        mark(here, scale, marker, fmt::format("{}: {:.2f} m, no other camera", marker.name, depth->z_m),
             kDoubtful);
        continue;
      }
      const Eigen::Vector3d there =
          fit.cameras[observation->camera].world_from_camera * observation->point_in_camera();
      const double off_mm = 1000 * (there - fit.markers[observation->marker].in_world).norm();
      mark(here, scale, marker, fmt::format("{}: {:.2f} m, {:.1f} mm", marker.name, depth->z_m, off_mm),
           off_mm <= 10   ? kGood
           : off_mm <= 30 ? kDoubtful
                          : kBad);
    }
  }
  return write_picture(all, file);
}

namespace {

constexpr int kTileWidth = 480, kScaleHeight = 34;
const cv::Vec3f kPink(230, 60, 250);  // BGR

// Colours: blue for a surface 20 mm in front, green for the same place, red for 20 mm behind.
cv::Vec3f color_of(double behind_mm) {
  const cv::Vec3f before(255, 110, 40), same(90, 215, 90), behind(50, 60, 255);
  const auto share = static_cast<float>(std::clamp(behind_mm / kFullColor_mm, -1.0, 1.0));
  return share < 0 ? same + (before - same) * -share : same + (behind - same) * share;
}

cv::Mat tile_of(const SurfaceComparison& one) {
  const Surface& surface = one.surface;
  const AssociationImage found = associate(surface, one.world_from_camera, one.other, one.world_from_other);
  const int width = surface.model.width, height = surface.model.height;
  cv::Mat tile(height, width, CV_8UC3, cv::Scalar(0, 0, 0));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (found.association(x, y) == Association::kNone) continue;
      // Shading by a light beside the camera makes shapes visible.
      const float lit =
          0.35f + 0.65f * std::max(0.0f, surface.normal(x, y).dot(Eigen::Vector3f(-0.4f, -0.4f, -0.82f)));
      cv::Vec3f color(110, 110, 110);
      if (found.association(x, y) == Association::kInlier) color = color_of(1000 * found.distance_m(x, y));
      if (found.association(x, y) == Association::kViolation) color = kPink;
      tile.at<cv::Vec3b>(y, x) = color * lit;
    }
  }
  cv::Mat scaled;
  cv::resize(tile, scaled, {kTileWidth, kTileWidth * height / width}, 0, 0, cv::INTER_AREA);
  write_label(scaled, one.label, {8, 18}, kWhite);
  return scaled;
}

void draw_scale(cv::Mat& picture) {
  const int top = picture.rows - kScaleHeight + 6, left = 120, width = 240;
  for (int x = 0; x < width; ++x) {
    const cv::Vec3f color = color_of(kFullColor_mm * (2.0 * x / (width - 1) - 1));
    cv::line(picture, {left + x, top}, {left + x, top + 12}, cv::Scalar(color[0], color[1], color[2]));
  }
  write_label(picture, fmt::format("{:.0f} mm in front", kFullColor_mm), {4, top + 11}, kWhite);
  write_label(picture, fmt::format("{:.0f} mm behind", kFullColor_mm), {left + width + 8, top + 11}, kWhite);
  cv::rectangle(picture, {500, top, 16, 12}, cv::Scalar(kPink[0], kPink[1], kPink[2]), cv::FILLED);
  write_label(picture, "the other sees through it", {522, top + 11}, kWhite);
  cv::rectangle(picture, {730, top, 16, 12}, {110, 110, 110}, cv::FILLED);
  write_label(picture, "the other does not see it", {752, top + 11}, kWhite);
}

}  // namespace

Result<void> write_agreement_picture(std::span<const SurfaceComparison> all,
                                     const std::filesystem::path& file) {
  cv::Mat picture(0, 2 * kTileWidth, CV_8UC3);
  for (std::size_t first = 0; first < all.size(); first += 2) {
    const cv::Mat left = tile_of(all[first]);
    const cv::Mat right = first + 1 < all.size() ? tile_of(all[first + 1]) : cv::Mat();
    cv::Mat row(std::max(left.rows, right.rows), 2 * kTileWidth, CV_8UC3, cv::Scalar(0, 0, 0));
    left.copyTo(row(cv::Rect(0, 0, left.cols, left.rows)));
    if (!right.empty()) right.copyTo(row(cv::Rect(kTileWidth, 0, right.cols, right.rows)));
    picture.push_back(row);
  }
  picture.push_back(cv::Mat(kScaleHeight, 2 * kTileWidth, CV_8UC3, cv::Scalar(0, 0, 0)));
  draw_scale(picture);
  return write_picture(picture, file);
}

}  // namespace copresence::calibrate
