#include "tools/record/from_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "capture_server/recording/oni_writer.h"
#include "common/frame/camera_model.h"
#include "tools/record/image_folder.h"

namespace copresence::record {
namespace {

using std::chrono::microseconds;

constexpr double kTumPerMetre = 5000, kUsualPerMetre = 1000;
// 7-Scenes' word for a hole; elsewhere the largest value that the file can hold, and so no measurement either.
constexpr std::uint16_t kNotMeasured = 65535;
// The nominal field of view of a Kinect v1, radians.
constexpr double kKinectHorizontal = 1.0144686, kKinectVertical = 0.7898090;

Result<std::vector<std::uint8_t>> bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || bytes.empty()) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: cannot be read, or is empty", path.string()));
  }
  return bytes;
}

cv::Mat decode(const std::vector<std::uint8_t>& bytes, int how) {
  try {
    return cv::imdecode(bytes, how);
  } catch (const cv::Exception&) {
    return {};
  }
}

tl::unexpected<Error> not_an_image(const std::filesystem::path& path) {
  return fail(ErrorCode::kCorrupt,
              fmt::format("{}: not a PNG or JPEG image, or damaged; take another copy of it", path.string()));
}

Result<cv::Mat> read_depth(const std::filesystem::path& path) {
  const auto bytes = bytes_of(path);
  if (!bytes) return fail(bytes.error());
  const cv::Mat image = decode(*bytes, cv::IMREAD_UNCHANGED);
  if (image.empty()) return not_an_image(path);
  if (image.type() != CV_16UC1) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: {} channels of {} bits, but depth must be a PNG of one channel of 16 bits; it may "
                    "be a picture for people, not the depth",
                    path.string(), image.channels(), 8 * image.elemSize1()));
  }
  if (image.cols % 2 != 0 || image.rows % 2 != 0 || image.cols > 4096 || image.rows > 4096) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: {}x{} pixels, but both must be even and at most 4096",
                                                 path.string(), image.cols, image.rows));
  }
  return image;
}

// OpenNI2's player takes three components only, and shows a picture as it is stored, not as its camera was held.
bool is_playable(const cv::Mat& as_stored, const cv::Mat& as_meant) {
  return as_stored.type() == as_meant.type() && as_stored.size() == as_meant.size() &&
         cv::norm(as_stored, as_meant, cv::NORM_INF) == 0;
}

struct Size {
  int width = 0, height = 0;
  friend bool operator==(const Size&, const Size&) = default;
};

Result<void> check_size(const std::filesystem::path& path, const cv::Mat& image, const Size& size) {
  if (Size{image.cols, image.rows} == size) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: {}x{} pixels, but the first image has {}x{}", path.string(), image.cols,
                          image.rows, size.width, size.height));
}

class Making {
 public:
  Making(const FromImagesSettings& settings, ImageFolder images)
      : settings_(settings), images_(std::move(images)) {
    report_.depth_per_metre =
        settings.depth_per_metre.value_or(images_.has_lists ? kTumPerMetre : kUsualPerMetre);
    units_per_value_ = 1e6 / static_cast<int>(settings.unit) / report_.depth_per_metre;
  }

  Result<FromImagesReport> run(const recording::ProgressReport& progress) {
    auto content = describe();
    if (!content) return fail(content.error());
    auto writer = recording::OniWriter::create(settings_.out, *content, recording::Existing::kReplace);
    if (!writer) return fail(writer.error());
    if (auto written = write(*writer, progress); !written) {
      writer->discard();
      return fail(written.error());
    }
    return report_;
  }

 private:
  Result<recording::OniContent> describe() {
    const auto first = read_depth(images_.depth.front().path);
    if (!first) return fail(first.error());
    depth_size_ = {first->cols, first->rows};
    recording::OniContent content;
    CameraModel model =
        camera_from_field_of_view(depth_size_.width, depth_size_.height, kKinectHorizontal, kKinectVertical);
    if (settings_.intrinsics) {
      const Intrinsics& given = *settings_.intrinsics;
      model = {depth_size_.width, depth_size_.height, given.fx,        given.fy,
               given.cx,          given.cy,           given.distortion};
    }
    content.camera.name = settings_.name;
    content.camera.model = model;
    content.camera.unit = settings_.unit;
    content.camera.registered = settings_.registered;
    content.max_depth = 65535;
    content.color.reset();
    content.jpeg_quality = settings_.jpeg_quality;
    content.frames_per_second = nominal_rate();
    if (images_.color.empty()) return content;

    const auto bytes = bytes_of(images_.color.front().path);
    if (!bytes) return fail(bytes.error());
    const cv::Mat color = decode(*bytes, cv::IMREAD_COLOR);
    if (color.empty()) return not_an_image(images_.color.front().path);
    if (color.cols % 2 != 0 || color.rows % 2 != 0) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: {}x{} pixels, but both must be even", images_.color.front().path.string(),
                              color.cols, color.rows));
    }
    color_size_ = {color.cols, color.rows};
    content.color = recording::ColorCoding::kJpeg;
    content.camera.registered = settings_.registered && color_size_ == depth_size_;
    if (!content.camera.registered) {
      content.camera.color = recording::ColorCameraNote{scaled(model, color_size_), {}};
    }
    return content;
  }

  // The same view in another size.
  static CameraModel scaled(CameraModel model, const Size& size) {
    const double x = static_cast<double>(size.width) / model.width;
    const double y = static_cast<double>(size.height) / model.height;
    model.fx *= x;
    model.cx = (model.cx + 0.5) * x - 0.5;
    model.fy *= y;
    model.cy = (model.cy + 0.5) * y - 0.5;
    model.width = size.width;
    model.height = size.height;
    return model;
  }

  int nominal_rate() const {
    const auto& depth = images_.depth;
    const double seconds = depth.back().time_s - depth.front().time_s;
    const double rate = depth.size() > 1 && seconds > 0 ? static_cast<double>(depth.size() - 1) / seconds
                                                        : settings_.frames_per_second;
    return static_cast<int>(std::lround(std::clamp(rate, 1.0, 1000.0)));
  }

  Result<void> write(recording::OniWriter& writer, const recording::ProgressReport& progress) {
    const double first_s = images_.color.empty()
                               ? images_.depth.front().time_s
                               : std::min(images_.depth.front().time_s, images_.color.front().time_s);
    // Times before zero, which nothing forbids in a list, begin at zero.
    const double zero_s = std::min(first_s, 0.0);
    const auto time_of = [&](const TimedImage& image) {
      return microseconds(std::llround((image.time_s - zero_s) * 1e6));
    };
    const std::size_t count = images_.depth.size() + images_.color.size();
    auto depth = images_.depth.begin();
    auto color = images_.color.begin();
    for (std::size_t done = 0; done < count; ++done) {
      const bool depth_next =
          color == images_.color.end() || (depth != images_.depth.end() && depth->time_s <= color->time_s);
      if (depth_next) {
        if (auto written = write_depth(writer, time_of(*depth), depth->path); !written) return written;
        ++depth;
      } else {
        if (auto written = write_color(writer, time_of(*color), color->path); !written) return written;
        ++color;
      }
      progress(static_cast<double>(done + 1) / static_cast<double>(count));
    }
    report_.bytes = writer.bytes();
    return writer.finish();
  }

  Result<void> write_depth(recording::OniWriter& writer, microseconds time,
                           const std::filesystem::path& path) {
    const auto image = read_depth(path);
    if (!image) return fail(image.error());
    if (auto fits = check_size(path, *image, depth_size_); !fits) return fits;
    DepthImage depth(image->cols, image->rows, 0);
    for (int y = 0; y < image->rows; ++y) {
      const auto* from = image->ptr<std::uint16_t>(y);
      for (int x = 0; x < image->cols; ++x) {
        if (from[x] == kNotMeasured) continue;
        const double units = from[x] * units_per_value_ + 0.5;
        report_.too_far += units >= 65536.0;
        depth(x, y) = units < 65536.0 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
      }
    }
    ++report_.depth_frames;
    return writer.write_depth(time, depth);
  }

  Result<void> write_color(recording::OniWriter& writer, microseconds time,
                           const std::filesystem::path& path) {
    const auto bytes = bytes_of(path);
    if (!bytes) return fail(bytes.error());
    const cv::Mat bgr = decode(*bytes, cv::IMREAD_COLOR);
    if (bgr.empty()) return not_an_image(path);
    if (auto fits = check_size(path, bgr, color_size_); !fits) return fits;
    ++report_.color_frames;
    const bool is_jpeg = bytes->size() > 2 && (*bytes)[0] == 0xFF && (*bytes)[1] == 0xD8;
    if (is_jpeg && is_playable(decode(*bytes, cv::IMREAD_UNCHANGED), bgr))
      return writer.write_jpeg(time, *bytes);
    ColorImage color(bgr.cols, bgr.rows);
    cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, color.data());
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    return writer.write_color(time, color);
  }

  const FromImagesSettings& settings_;
  const ImageFolder images_;
  double units_per_value_ = 1;
  Size depth_size_, color_size_;
  FromImagesReport report_;
};

}  // namespace

Result<FromImagesReport> make_from_images(const FromImagesSettings& settings,
                                          const recording::ProgressReport& progress) {
  auto images = find_images(settings.folder, settings.frames_per_second);
  if (!images) return fail(images.error());
  return Making(settings, std::move(*images)).run(progress);
}

}  // namespace copresence::record
