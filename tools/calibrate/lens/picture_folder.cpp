#include "tools/calibrate/lens/picture_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>

#include "common/frame/camera_model.h"
#include "tools/pictures/picture_header.h"

namespace copresence::calibrate {
namespace {

namespace fs = std::filesystem;

using Bytes = std::span<const unsigned char>;

// Unsigned numbers of two and four bytes; 0 beyond the end.
unsigned number(Bytes bytes, std::size_t at, std::size_t size, bool big_endian) {
  unsigned value = 0;
  if (at > bytes.size() || bytes.size() - at < size) return 0;
  for (std::size_t i = 0; i < size; ++i) {
    const unsigned byte = bytes[at + i];
    value |= byte << (8 * (big_endian ? size - 1 - i : i));
  }
  return value;
}

// The orientation in the first directory of an EXIF block, which is a TIFF file.
int exif_orientation(Bytes segment) {
  constexpr std::array<unsigned char, 6> kExif{'E', 'x', 'i', 'f', 0, 0};
  if (segment.size() < 14 || !std::equal(kExif.begin(), kExif.end(), segment.begin())) return 1;
  const Bytes tiff = segment.subspan(kExif.size());
  const bool big_endian = tiff[0] == 'M';
  const std::size_t directory = number(tiff, 4, 4, big_endian);
  const unsigned entries = number(tiff, directory, 2, big_endian);
  constexpr unsigned kOrientation = 0x0112;
  for (unsigned i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + std::size_t{12} * i;
    if (entry + 12 > tiff.size()) break;
    if (number(tiff, entry, 2, big_endian) != kOrientation) continue;
    const unsigned orientation = number(tiff, entry + 8, 2, big_endian);
    return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  }
  return 1;
}

std::optional<PictureHeader> png_header(std::istream& file) {
  std::array<unsigned char, 24> head{};
  constexpr std::array<unsigned char, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (!file.read(reinterpret_cast<char*>(head.data()), head.size())) return std::nullopt;
  if (!std::equal(kSignature.begin(), kSignature.end(), head.begin())) return std::nullopt;
  const unsigned width = number(head, 16, 4, true), height = number(head, 20, 4, true);
  if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) return std::nullopt;
  return PictureHeader{static_cast<int>(width), static_cast<int>(height)};
}

// Segments up to the one that holds the size (SOF).
std::optional<PictureHeader> jpeg_header(std::istream& file) {
  constexpr int kMostSegments = 10000;
  PictureHeader header;
  std::array<unsigned char, 2> two{};
  const auto read_two = [&] { return bool(file.read(reinterpret_cast<char*>(two.data()), 2)); };
  if (!read_two() || two[0] != 0xff || two[1] != 0xd8) return std::nullopt;
  for (int segment = 0; segment < kMostSegments; ++segment) {
    int marker = 0;
    if (file.get() != 0xff) return std::nullopt;
    do marker = file.get();
    while (marker == 0xff);
    if (!read_two()) return std::nullopt;
    const unsigned length = number(two, 0, 2, true);
    if (length < 2) return std::nullopt;
    std::vector<unsigned char> content(length - 2);
    if (!file.read(reinterpret_cast<char*>(content.data()), static_cast<std::streamsize>(content.size()))) {
      return std::nullopt;
    }
    if (marker == 0xe1) header.orientation = std::max(header.orientation, exif_orientation(content));
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (!is_frame) continue;
    header.height = static_cast<int>(number(content, 1, 2, true));
    header.width = static_cast<int>(number(content, 3, 2, true));
    return header.width > 0 && header.height > 0 ? std::optional(header) : std::nullopt;
  }
  return std::nullopt;
}

using Size = std::pair<int, int>;

// "a.jpg, b.jpg, c.jpg and 4 more"
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
                               : "all must be of one camera, in one mode, and neither cut nor scaled")};
  }
  return {};
}

// Empty where the size can be used, perhaps without its last column or row.
std::string problem_of_size(int width, int height) {
  const auto checked = check(CameraModel{width / 2 * 2, height / 2 * 2, 1, 1, 0, 0, {}});
  if (checked) return {};
  constexpr int kLarge = 1000;
  return checked.error().what +
         (std::max(width, height) > kLarge ? "; scale all pictures down by the same factor" : "");
}

}  // namespace

Result<PictureHeader> read_picture_header(const fs::path& file) {
  for (const auto read : {png_header, jpeg_header}) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return fail(ErrorCode::kNotFound, fmt::format("{}: cannot be read", file.string()));
    if (const auto header = read(stream)) return *header;
  }
  return fail(ErrorCode::kCorrupt, fmt::format("{}: is no PNG or JPEG picture", file.string()));
}

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
    const auto header = read_picture_header(file);
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
        "{} of {} pictures name an orientation (EXIF); all are taken as the sensor saw them, {}x{} pixels",
        turned, pictures.files.size(), width, height));
  }
  if (pictures.width != width || pictures.height != height) {
    remarks.push_back(fmt::format(
        "sizes must be even, so the last {} of {}x{} pixels is left out: the lens is that of {}x{} pixels",
        pictures.width == width ? "row" : (pictures.height == height ? "column" : "column and row"), width,
        height, pictures.width, pictures.height));
  }
  pictures.remark = fmt::format("{}", fmt::join(remarks, "\n"));
  return pictures;
}

Result<ColorImage> load_picture(const PictureFolder& folder, const fs::path& file) {
  // Checks the size before a small file unpacks to gigabytes.
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
