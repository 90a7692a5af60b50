#include "tools/calibrate/lens/picture_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/pictures/picture_header.h"

namespace copresence::calibrate {

Result<std::vector<std::filesystem::path>> picture_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code problem;
  for (const auto& entry : std::filesystem::directory_iterator(folder, problem)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (ending == ".png" || ending == ".jpg" || ending == ".jpeg") files.push_back(entry.path());
  }
  if (files.empty()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: there are no PNG or JPEG pictures in it", folder.string()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

Result<ColorImage> load_picture(const std::filesystem::path& file) {
  // Checks the size before a small file unpacks to gigabytes.
  const auto bytes = pictures::load(file);
  if (!bytes) return fail(bytes.error());
  cv::Mat bgr;
  try {
    bgr = cv::imdecode(*bytes, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    bgr.release();
  }
  if (bgr.empty()) return fail(ErrorCode::kCorrupt, fmt::format("{}: is no picture", file.string()));
  ColorImage picture(bgr.cols, bgr.rows);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, picture.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return picture;
}

}  // namespace copresence::calibrate
