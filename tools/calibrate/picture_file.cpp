#include "tools/calibrate/picture_file.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace copresence::calibrate {

void write_label(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, color, 1, cv::LINE_AA);
}

Result<void> write_picture(const cv::Mat& picture, const std::filesystem::path& file) {
  try {
    if (cv::imwrite(file.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 80})) return {};
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the picture cannot be written", file.string()));
  } catch (const cv::Exception&) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: end the picture's name with .png or .jpg", file.string()));
  }
}

}  // namespace copresence::calibrate
