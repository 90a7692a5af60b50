#include "tools/calibrate/agreement_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/alignment/agreement.h"
#include "tools/calibrate/picture_file.h"

namespace copresence::calibrate {
namespace {

using alignment::Meeting;

constexpr int kTileWidth = 480, kScaleHeight = 34;
const cv::Vec3f kPink(230, 60, 250);  // blue, green, red
const cv::Scalar kWhite(255, 255, 255);

// From blue over green to red as the other's surface goes from 20 mm before to 20 mm behind.
cv::Vec3f color_of(double behind_mm) {
  const cv::Vec3f before(255, 110, 40), same(90, 215, 90), behind(50, 60, 255);
  const auto share = static_cast<float>(std::clamp(behind_mm / kFullColor_mm, -1.0, 1.0));
  return share < 0 ? same + (before - same) * -share : same + (behind - same) * share;
}

cv::Mat tile_of(const SeenAgainst& one) {
  const alignment::Surface& surface = one.surface;
  const alignment::Meetings found =
      alignment::find_meetings(surface, one.world_from_camera, one.other, one.world_from_other);
  const int width = surface.model.width, height = surface.model.height;
  cv::Mat tile(height, width, CV_8UC3, cv::Scalar(0, 0, 0));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (found.meeting(x, y) == Meeting::kNone) continue;
      // As if lit from beside the camera, so that shapes can be made out.
      const float lit =
          0.35f + 0.65f * std::max(0.0f, surface.normal(x, y).dot(Eigen::Vector3f(-0.4f, -0.4f, -0.82f)));
      cv::Vec3f color(110, 110, 110);
      if (found.meeting(x, y) == Meeting::kMeets) color = color_of(1000 * found.distance_m(x, y));
      if (found.meeting(x, y) == Meeting::kContradicts) color = kPink;
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
  write_label(picture, fmt::format("{:.0f} mm before", kFullColor_mm), {4, top + 11}, kWhite);
  write_label(picture, fmt::format("{:.0f} mm behind", kFullColor_mm), {left + width + 8, top + 11}, kWhite);
  cv::rectangle(picture, {500, top, 16, 12}, cv::Scalar(kPink[0], kPink[1], kPink[2]), cv::FILLED);
  write_label(picture, "the other looks through it", {522, top + 11}, kWhite);
  cv::rectangle(picture, {730, top, 16, 12}, {110, 110, 110}, cv::FILLED);
  write_label(picture, "the other does not see it", {752, top + 11}, kWhite);
}

}  // namespace

Result<void> write_agreement_picture(std::span<const SeenAgainst> all, const std::filesystem::path& file) {
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
