#include "tools/calibrate/picture_file.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/command_line/values.h"

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

void write_label(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, color, 1, cv::LINE_AA);
}

Result<void> write_picture(const cv::Mat& picture, const std::filesystem::path& file) {
  if (cv::imwrite(file.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 80})) return {};
  return fail(ErrorCode::kUnavailable, fmt::format("{}: the picture cannot be written", file.string()));
}

}  // namespace copresence::calibrate
