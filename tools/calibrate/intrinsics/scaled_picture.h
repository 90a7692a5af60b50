#pragma once

// A grey picture scaled down for a search. Converts positions back to full pixels.
// Thread: one thread per object.

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/frame/image.h"

namespace copresence::calibrate {

/// Longer sides for thorough searches, pixels. These sizes limit the time of a search.
inline constexpr std::array kSearchSides{1280, 2560};

inline cv::Mat gray_of(const ColorImage& picture) {
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat gray;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

class ScaledPicture {
 public:
  /// `side` is the length of the longer side in pixels. A smaller picture keeps its size.
  ScaledPicture(const cv::Mat& gray, int side) : gray_(gray) {
    const double scale = static_cast<double>(side) / std::max(gray.cols, gray.rows);
    if (scale < 1) {
      const cv::Size size(std::max(1, cvRound(gray.cols * scale)), std::max(1, cvRound(gray.rows * scale)));
      cv::resize(gray, gray_, size, 0, 0, cv::INTER_AREA);
    }
    x_ = static_cast<float>(gray.cols) / static_cast<float>(gray_.cols);
    y_ = static_cast<float>(gray.rows) / static_cast<float>(gray_.rows);
  }

  const cv::Mat& gray() const { return gray_; }
  /// Size of one pixel of the small picture, in pixels of the full picture.
  float pixel() const { return std::max(x_, y_); }
  void to_full(std::vector<cv::Point2f>& points) const {
    for (cv::Point2f& p : points) p = {(p.x + 0.5f) * x_ - 0.5f, (p.y + 0.5f) * y_ - 0.5f};
  }

 private:
  cv::Mat gray_;
  float x_ = 1, y_ = 1;
};

}  // namespace copresence::calibrate
