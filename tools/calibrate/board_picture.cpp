#include "tools/calibrate/board_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/picture_file.h"

namespace copresence::calibrate {
namespace {

constexpr int kWidth = 240, kColumns = 4;
constexpr std::size_t kMost = 24;
const cv::Scalar kWhite(255, 255, 255), kGood(80, 220, 80), kBad(60, 60, 255);  // blue, green, red

cv::Point at(const Eigen::Vector2d& pixel) {
  return {cv::saturate_cast<int>(pixel.x()), cv::saturate_cast<int>(pixel.y())};
}

}  // namespace

void BoardPictures::add(const BoardView& view, const ColorImage& picture) {
  const double scale = static_cast<double>(kWidth) / picture.width();
  const cv::Mat all(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  Small small{ColorImage(kWidth, static_cast<int>(scale * picture.height())), {}};
  cv::Mat scaled(small.picture.height(), kWidth, CV_8UC3, small.picture.data());
  cv::resize(all, scaled, scaled.size(), 0, 0, cv::INTER_AREA);
  for (const Eigen::Vector2d& pixel : view.pixels) small.corners.push_back(scale * pixel);
  pictures_[view.picture] = std::move(small);
}

Result<void> BoardPictures::write(const LensFit& fit, const std::filesystem::path& file) const {
  std::vector<ViewFit> views = fit.views;
  std::erase_if(views, [&](const ViewFit& view) { return !pictures_.contains(view.picture); });
  std::stable_sort(views.begin(), views.end(),
                   [](const ViewFit& a, const ViewFit& b) { return a.rms_px > b.rms_px; });
  views.resize(std::min(views.size(), kMost - 1));
  const int height = kWidth * fit.model.height / fit.model.width;
  const int tiles = static_cast<int>(views.size()) + 1;
  cv::Mat sheet(height * ((tiles + kColumns - 1) / kColumns), kWidth * kColumns, CV_8UC3,
                cv::Scalar(0, 0, 0));
  const auto tile = [&](int number) {
    return sheet(cv::Rect(number % kColumns * kWidth, number / kColumns * height, kWidth, height));
  };
  cv::Mat covered = tile(tiles - 1);
  for (const ViewFit& view : fit.views) {
    const auto found = pictures_.find(view.picture);
    if (found == pictures_.end()) continue;
    for (const Eigen::Vector2d& corner : found->second.corners) {
      cv::circle(covered, at(corner), 1, kGood, cv::FILLED);
    }
  }
  for (int number = 0; number + 1 < tiles; ++number) {
    const ViewFit& view = views[static_cast<std::size_t>(number)];
    const auto found = pictures_.find(view.picture);
    if (found == pictures_.end()) continue;
    const Small& small = found->second;
    cv::Mat here = tile(number);
    const cv::Mat rgb(small.picture.height(), small.picture.width(), CV_8UC3,
                      const_cast<Rgb8*>(small.picture.data()));
    cv::cvtColor(rgb(cv::Rect(0, 0, kWidth, std::min(height, rgb.rows))),
                 here(cv::Rect(0, 0, kWidth, std::min(height, rgb.rows))), cv::COLOR_RGB2BGR);
    const cv::Scalar color = view.rms_px < 0.5 ? kGood : kBad;
    for (std::size_t i = 0; i < small.corners.size(); ++i) {
      if (i > 0) cv::line(here, at(small.corners[i - 1]), at(small.corners[i]), color, 1, cv::LINE_AA);
      cv::circle(here, at(small.corners[i]), 2, color, 1, cv::LINE_AA);
    }
    write_label(here, fmt::format("{}: {:.2f} px", view.picture, view.rms_px), {6, height - 8}, kWhite);
  }
  write_label(covered, fmt::format("covered: {:.0f} %", 100 * fit.covered), {6, height - 8}, kWhite);
  return write_picture(sheet, file);
}

}  // namespace copresence::calibrate
