#include "tools/record/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "tools/pictures/picture_header.h"

namespace copresence::record {
namespace {

namespace fs = std::filesystem;
using pictures::Format;

constexpr std::uint64_t kMostPixels = std::uint64_t{kLargestSide} * kLargestSide;
// The value of a hole in 7-Scenes. It is not a measurement in other data sets either.
constexpr std::uint16_t kNotMeasured = 65535;
// A Kinect's raw disparity has 11 bits; the largest value stands for a hole. The toolbox of NYU
// Depth v2 converts it to metres by kMetresTimesDisparity / (kDisparityAtInfinity - raw).
constexpr int kNoDisparity = 2047;
constexpr double kDisparityAtInfinity = 1092.5;
constexpr double kMetresTimesDisparity = kKinectV1Noise.disparity_constant_m;
// The image in the right byte order must be smoother than the other by this factor.
constexpr double kSmoother = 3;

struct Loaded {
  pictures::PictureHeader header;
  std::vector<std::uint8_t> bytes;
};

Result<Loaded> load(const fs::path& path) {
  const auto header = pictures::read_header(path);
  if (!header) return fail(header.error());
  if (header->width > kLargestSide || header->height > kLargestSide) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: {}x{} pixels, but width and height must not exceed {}; scale the images down",
                    path.string(), header->width, header->height, kLargestSide));
  }
  auto bytes = pictures::load(path, kMostPixels);
  if (!bytes) return fail(bytes.error());
  return Loaded{*header, std::move(*bytes)};
}

cv::Mat decode(const std::vector<std::uint8_t>& bytes, int how) {
  try {
    return cv::imdecode(bytes, how);
  } catch (const cv::Exception&) {
    return {};
  }
}

tl::unexpected<Error> does_not_decode(const fs::path& path) {
  return fail(ErrorCode::kCorrupt,
              fmt::format("{}: the image is damaged and cannot be decoded; use another copy", path.string()));
}

// Returns the offset of the pixels after a Netpbm or PFM header of `numbers` numbers. One
// white-space byte follows the last number.
std::size_t end_of_header(const std::vector<std::uint8_t>& bytes, int numbers) {
  std::size_t at = 2;
  for (int i = 0; i < numbers; ++i) {
    while (at < bytes.size() && (std::isspace(bytes[at]) || bytes[at] == '#')) {
      if (bytes[at] == '#') {
        while (at < bytes.size() && bytes[at] != '\n') ++at;
      } else {
        ++at;
      }
    }
    while (at < bytes.size() && !std::isspace(bytes[at])) ++at;
  }
  return at + 1;
}

// PFM stores floats, beginning with the bottom row. A negative scale means little-endian.
cv::Mat decode_pfm(const Loaded& loaded) {
  const std::size_t begin = end_of_header(loaded.bytes, 3);
  const std::size_t row_bytes = 4u * static_cast<std::size_t>(loaded.header.width);
  const auto rows = static_cast<std::size_t>(loaded.header.height);
  if (loaded.header.channels != 1 || begin > loaded.bytes.size() ||
      loaded.bytes.size() - begin < rows * row_bytes) {
    return {};
  }
  const auto header_end = loaded.bytes.begin() + static_cast<std::ptrdiff_t>(begin);
  const bool little = std::find(loaded.bytes.begin(), header_end, '-') != header_end;
  cv::Mat image(loaded.header.height, loaded.header.width, CV_32FC1);
  for (std::size_t y = 0; y < rows; ++y) {
    auto* to = image.ptr<std::uint8_t>(static_cast<int>(rows - 1 - y));
    std::memcpy(to, loaded.bytes.data() + begin + y * row_bytes, row_bytes);
    for (std::size_t i = 0; !little && i < row_bytes; i += 4) std::reverse(to + i, to + i + 4);
  }
  return image;
}

cv::Mat even(const cv::Mat& image) {
  return image(cv::Rect(0, 0, image.cols & ~1, image.rows & ~1));
}

std::uint16_t swapped(std::uint16_t value) {
  return static_cast<std::uint16_t>(value << 8 | value >> 8);
}

template <class Value>
double roughness(const cv::Mat& image, Value value) {
  double sum = 0;
  std::uint64_t count = 0;
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<std::uint16_t>(y);
    for (int x = 1; x < image.cols; ++x) {
      if (row[x] == 0 || row[x - 1] == 0 || row[x] == kNotMeasured || row[x - 1] == kNotMeasured) continue;
      sum += std::abs(static_cast<int>(value(row[x])) - static_cast<int>(value(row[x - 1])));
      ++count;
    }
  }
  return count ? sum / static_cast<double>(count) : 0;
}

// True for 8-bit depth that was scaled to 16 bits. Scaled depth is smooth in either byte order.
bool has_empty_low_bytes(const cv::Mat& image) {
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<std::uint16_t>(y);
    if (std::any_of(row, row + image.cols, [](std::uint16_t value) { return value % 256 != 0; }))
      return false;
  }
  return true;
}

// Raw disparities are never 0, and images of raw disparities have holes.
template <class Value>
bool are_disparities(const cv::Mat& image, Value value) {
  bool has_hole = false;
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<std::uint16_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      const int number = value(row[x]);
      if (number == 0 || number > kNoDisparity) return false;
      has_hole = has_hole || number == kNoDisparity;
    }
  }
  return has_hole;
}

bool is_swapped(DepthCoding coding) {
  return coding == DepthCoding::kSwapped || coding == DepthCoding::kSwappedDisparity;
}

bool is_disparity(DepthCoding coding) {
  return coding == DepthCoding::kKinectDisparity || coding == DepthCoding::kSwappedDisparity;
}

// Pixel values in the right byte order: metres for disparities, 0 for holes.
class Pixels {
 public:
  Pixels(const cv::Mat& image, DepthCoding coding) : image_(image), coding_(coding) {}

  double at(int x, int y) const {
    if (image_.type() == CV_32FC1) {
      const float value = image_.at<float>(y, x);
      return std::isfinite(value) && value > 0 ? value : 0;
    }
    const std::uint16_t stored = image_.at<std::uint16_t>(y, x);
    const std::uint16_t value = is_swapped(coding_) ? swapped(stored) : stored;
    if (is_disparity(coding_)) {
      const double disparity = kDisparityAtInfinity - value;
      return value == kNoDisparity || disparity <= 0 ? 0 : kMetresTimesDisparity / disparity;
    }
    return value == kNotMeasured ? 0 : value;
  }

 private:
  const cv::Mat& image_;
  const DepthCoding coding_;
};

// True if OpenNI2's player shows the JPEG correctly. The player needs three components and ignores
// the EXIF orientation.
bool is_playable(const cv::Mat& as_stored, const cv::Mat& as_meant) {
  return as_stored.type() == as_meant.type() && as_stored.size() == as_meant.size() &&
         cv::norm(as_stored, as_meant, cv::NORM_INF) == 0;
}

}  // namespace

Result<cv::Mat> read_depth(const fs::path& path) {
  const auto loaded = load(path);
  if (!loaded) return fail(loaded.error());
  const bool is_pfm = loaded->header.format == Format::kPfm;
  const cv::Mat image = is_pfm ? decode_pfm(*loaded) : decode(loaded->bytes, cv::IMREAD_UNCHANGED);
  if (image.empty()) return does_not_decode(path);
  if (image.type() != CV_16UC1 && image.type() != CV_32FC1) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} channels of {} bits, but depth must have one channel of 16 bits or of "
                            "floating-point numbers; this may be a visualisation of depth",
                            path.string(), image.channels(), 8 * image.elemSize1()));
  }
  if (image.cols < 2 || image.rows < 2) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: {}x{} pixels are too few for a depth image",
                                                 path.string(), image.cols, image.rows));
  }
  return even(image);
}

DepthCoding find_coding(const cv::Mat& first, const fs::path& path) {
  if (first.type() == CV_32FC1) return DepthCoding::kFloat;
  const auto same = [](std::uint16_t value) { return value; };
  const auto header = pictures::read_header(path);
  const bool is_netpbm = header && header->format == Format::kNetpbm;
  const bool are_swapped =
      !has_empty_low_bytes(first) && kSmoother * roughness(first, swapped) < roughness(first, same);
  if (is_netpbm) {
    if (!are_swapped && are_disparities(first, same)) return DepthCoding::kKinectDisparity;
    if (are_swapped && are_disparities(first, swapped)) return DepthCoding::kSwappedDisparity;
  }
  return are_swapped ? DepthCoding::kSwapped : DepthCoding::kWhole;
}

double median_depth(const cv::Mat& stored, DepthCoding coding) {
  const Pixels pixels(stored, coding);
  std::vector<double> values;
  for (int y = 0; y < stored.rows; ++y) {
    for (int x = 0; x < stored.cols; ++x) {
      if (const double value = pixels.at(x, y); value > 0) values.push_back(value);
    }
  }
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

DepthImage convert_depth(const cv::Mat& stored, DepthCoding coding, double per_metre, DepthUnit unit,
                         std::uint64_t& too_far) {
  const Pixels pixels(stored, coding);
  const double units_per_value = 1e6 / static_cast<int>(unit) / (is_disparity(coding) ? 1 : per_metre);
  DepthImage depth(stored.cols, stored.rows, 0);
  for (int y = 0; y < stored.rows; ++y) {
    for (int x = 0; x < stored.cols; ++x) {
      const double units = pixels.at(x, y) * units_per_value + 0.5;
      too_far += units >= 65536.0;
      depth(x, y) = units < 65536.0 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
    }
  }
  return depth;
}

Result<ColorPicture> read_color(const fs::path& path) {
  auto loaded = load(path);
  if (!loaded) return fail(loaded.error());
  const cv::Mat bgr = decode(loaded->bytes, cv::IMREAD_COLOR);
  if (bgr.empty()) return does_not_decode(path);
  if (bgr.cols < 2 || bgr.rows < 2) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: {}x{} pixels are too few for a colour image",
                                                 path.string(), bgr.cols, bgr.rows));
  }
  ColorPicture picture;
  picture.bgr = even(bgr);
  const bool is_whole = picture.bgr.size() == bgr.size();
  if (is_whole && loaded->header.format == Format::kJpeg &&
      is_playable(decode(loaded->bytes, cv::IMREAD_UNCHANGED), bgr)) {
    picture.jpeg_as_is = std::move(loaded->bytes);
  }
  return picture;
}

Result<bool> is_odd(const fs::path& path) {
  const auto header = pictures::read_header(path);
  if (!header) return fail(header.error());
  return header->width % 2 != 0 || header->height % 2 != 0;
}

}  // namespace copresence::record
