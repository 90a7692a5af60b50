#include "render_client/screenshot.h"

#include <fmt/format.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace copresence::client {

Result<void> write_png(const std::string& path, const Image<Rgba8>& image) {
  const cv::Mat rgba(image.height(), image.width(), CV_8UC4, const_cast<Rgba8*>(image.data()));
  cv::Mat bgr;
  cv::cvtColor(rgba, bgr, cv::COLOR_RGBA2BGR);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", bgr, png);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  file.flush();
  if (!file)
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the picture cannot be written there", path));
  return {};
}

}  // namespace copresence::client
