#include "tools/calibrate/intrinsics/picture_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/frame/camera_model.h"
#include "tools/pictures/picture_header.h"

namespace copresence::calibrate {
namespace {

namespace fs = std::filesystem;

using Size = std::pair<int, int>;

// Lists the first names: "a.jpg, b.jpg, c.jpg and 4 more".
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  if (names.size() <= kShown) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{} and {} more", fmt::join(names.begin(), names.begin() + kShown, ", "),
                     names.size() - kShown);
}

Error of_different_sizes(const fs::path& folder, const std::map<Size, std::vector<std::string>>& by_size) {
  const auto usual = std::max_element(by_size.begin(), by_size.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  const auto [width, height] = usual->first;
  for (const auto& [size, names] : by_size) {
    if (size == usual->first) continue;
    const bool turned = size == Size(height, width);
    return {ErrorCode::kInvalid,
            fmt::format("{}: {} {} {}x{} pixels, the others {}x{}: {}", folder.string(), some_of(names),
                        names.size() == 1 ? "has" : "have", size.first, size.second, width, height,
                        turned ? "a program has turned the picture; turn it back or leave it out"
                               : "all must be of one camera, in one mode, and neither cropped nor scaled")};
  }
  return {};
}

// Returns an error message if no camera model can have this size, rounded down to even numbers.
std::string problem_of_size(int width, int height) {
  constexpr double kAnyFieldOfView = 1;  // Any angle would do, since only the picture's size is checked.
  const auto checked = check(camera_from_field_of_view(width / 2 * 2, height / 2 * 2, kAnyFieldOfView));
  if (checked) return {};
  constexpr int kLarge = 1000;
  return checked.error().what +
         (std::max(width, height) > kLarge ? "; scale all pictures down by the same factor" : "");
}

}  // namespace

Result<PictureFolder> open_picture_folder(const fs::path& folder) {
  PictureFolder pictures;
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(folder, problem)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool is_picture = ending == ".png" || ending == ".jpg" || ending == ".jpeg";
    const bool is_hidden = entry.path().filename().string().starts_with('.');
    if (is_picture && !is_hidden) pictures.files.push_back(entry.path());
  }
  if (pictures.files.empty()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: there are no PNG or JPEG pictures in it", folder.string()));
  }
  std::sort(pictures.files.begin(), pictures.files.end());
  std::map<Size, std::vector<std::string>> by_size;
  std::size_t turned = 0;
  for (const fs::path& file : pictures.files) {
    const auto header = pictures::read_header(file);
    if (!header) return fail(header.error());
    by_size[{header->width, header->height}].push_back(file.filename().string());
    turned += header->orientation == 1 ? 0 : 1;
  }
  if (by_size.size() > 1) return fail(of_different_sizes(folder, by_size));
  const auto [width, height] = by_size.begin()->first;
  if (const std::string wrong = problem_of_size(width, height); !wrong.empty()) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: {}", folder.string(), wrong));
  }
  pictures.width = width / 2 * 2;
  pictures.height = height / 2 * 2;
  std::vector<std::string> remarks;
  if (turned > 0) {
    remarks.push_back(fmt::format(
        "{} of {} pictures have an orientation (EXIF), which is ignored: all are used as {}x{} pixels",
        turned, pictures.files.size(), width, height));
  }
  if (pictures.width != width || pictures.height != height) {
    remarks.push_back(fmt::format(
        "sizes must be even, so the last {} of {}x{} pixels is left out: the intrinsics are for {}x{} pixels",
        pictures.width == width ? "row" : (pictures.height == height ? "column" : "column and row"), width,
        height, pictures.width, pictures.height));
  }
  pictures.remark = fmt::format("{}", fmt::join(remarks, "\n"));
  return pictures;
}

Result<ColorImage> load_picture(const PictureFolder& folder, const fs::path& file) {
  // Loading checks the size first, because a small file may decode to gigabytes.
  const auto bytes = pictures::load(file);
  if (!bytes) return fail(bytes.error());
  cv::Mat bgr;
  try {
    bgr = cv::imdecode(*bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    bgr.release();
  }
  if (bgr.cols < folder.width || bgr.rows < folder.height) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: the picture is damaged", file.string()));
  }
  ColorImage picture(folder.width, folder.height);
  cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, picture.data());
  cv::cvtColor(bgr(cv::Rect(0, 0, picture.width(), picture.height())), rgb, cv::COLOR_BGR2RGB);
  return picture;
}

}  // namespace copresence::calibrate
