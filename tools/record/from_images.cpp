#include "tools/record/from_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_writer.h"
#include "common/frame/camera_model.h"
#include "tools/record/export_folder.h"
#include "tools/record/image_file.h"
#include "tools/record/image_folder.h"

namespace copresence::record {
namespace {

using std::chrono::microseconds;

constexpr double kTumPerMetre = 5000, kUsualPerMetre = 1000, kFloatPerMetre = 1;
// Floating-point depth with a larger median is in millimetres.
constexpr double kFarthestMedian = 100;
// Plausible medians of depth in a room, metres. Outside this range the scale is probably wrong.
constexpr double kNearestRoom = 0.35, kFarthestRoom = 12;

struct Size {
  int width = 0, height = 0;
  friend bool operator==(const Size&, const Size&) = default;
};

bool has_size(const CameraModel& model, const Size& size) {
  return model.width == size.width && model.height == size.height;
}

Size size_of(const cv::Mat& image) {
  return {image.cols, image.rows};
}

Result<void> check_size(const std::filesystem::path& path, const cv::Mat& image, const Size& size) {
  if (size_of(image) == size) return {};
  return fail(
      ErrorCode::kInvalid,
      fmt::format(
          "{}: {}x{} pixels, but the first image has {}x{}; move images of other sizes to another folder",
          path.string(), image.cols, image.rows, size.width, size.height));
}

// Scales a camera model to another picture size. Pixel shape and centre do not change.
CameraModel scaled(const CameraModel& model, const Size& size) {
  const double scale = static_cast<double>(size.width) / model.width;
  CameraModel other = model;
  other.fx *= scale;
  other.fy *= scale;
  other.cx = (model.cx - 0.5 * (model.width - 1)) * scale + 0.5 * (size.width - 1);
  other.cy = (model.cy - 0.5 * (model.height - 1)) * scale + 0.5 * (size.height - 1);
  other.width = size.width;
  other.height = size.height;
  return other;
}

class ImageImport {
 public:
  ImageImport(const FromImagesSettings& settings, ImageFolder images, std::optional<ExportedCamera> exported)
      : settings_(settings),
        images_(std::move(images)),
        exported_(std::move(exported)),
        unit_(settings.unit.value_or(exported_ ? exported_->camera.unit : DepthUnit::kMillimetre)) {
    report_.remarks = images_.remarks;
    if (exported_) report_.remarks.emplace_back("the camera's data are those of camera.json");
    // Lists may contain negative times. The first time becomes the zero of the recording.
    zero_ = std::min(images_.depth.front().time, microseconds(0));
    if (!images_.color.empty()) zero_ = std::min(images_.color.front().time, zero_);
  }

  Result<FromImagesReport> run(const recording::ProgressReport& progress) {
    const auto times = times_of_depth();
    if (auto plays = recording::check_playable(times, settings_.folder); !plays) return fail(plays.error());
    remark_on_times(times);
    auto content = describe(times);
    if (!content) return fail(content.error());
    auto writer = recording::OniWriter::create(
        settings_.out, *content, settings_.overwrite ? file::Existing::kReplace : file::Existing::kKeep);
    if (!writer) return fail(writer.error());
    auto done = write(*writer, progress);
    if (done) done = recording::check_written(settings_.out);
    if (!done) {
      writer->discard();
      return fail(done.error());
    }
    return report_;
  }

 private:
  microseconds time_of(const TimedImage& image) const { return image.time - zero_; }

  // The times of the depth stream to be written.
  recording::RecordedStream times_of_depth() const {
    recording::RecordedStream stream;
    stream.frames_per_second = static_cast<int>(std::lround(settings_.frames_per_second));
    for (const TimedImage& image : images_.depth) {
      stream.timestamps_us.push_back(static_cast<std::uint64_t>(time_of(image).count()));
    }
    return stream;
  }

  void remark_on_times(const recording::RecordedStream& times) {
    const double seconds =
        static_cast<double>((images_.depth.back().time - images_.depth.front().time).count()) * 1e-6;
    std::string text = fmt::format("times are {}", name(images_.unit));
    if (images_.unit == TimeUnit::kFrames)
      text += fmt::format(" at {:g} frames/s", settings_.frames_per_second);
    text += fmt::format(": {:.2f} s, {:.1f} frames/s", seconds, 1e6 / recording::usual_period_us(times));
    if (images_.since_1970) text += ", from " + utc_text(images_.depth.front().time);
    report_.remarks.push_back(std::move(text));
    const std::size_t standing = recording::steps_without_time(times);
    if (standing) {
      report_.remarks.push_back(fmt::format(
          "{} depth images have the same time as the image before; they are played at {} frames/s", standing,
          times.frames_per_second));
    }
  }

  Result<recording::OniContent> describe(const recording::RecordedStream& times) {
    const std::filesystem::path& path = images_.depth.front().path;
    const auto first = read_depth(path);
    if (!first) return fail(first.error());
    coding_ = find_coding(*first, path);
    choose_scale(*first);
    depth_size_ = size_of(*first);
    const auto depth_is_odd = is_odd(path);
    if (!depth_is_odd) return fail(depth_is_odd.error());
    if (*depth_is_odd) remark_on_odd_size("depth", depth_size_);

    recording::OniContent content;
    content.camera.name = camera_name();
    content.camera.model = camera_of(depth_size_);
    content.camera.unit = unit_;
    if (exported_) content.camera.world_from_camera = exported_->camera.world_from_camera;
    content.camera.registered = is_registered();
    content.max_depth = 65535;
    content.color.reset();
    content.jpeg_quality = settings_.jpeg_quality;
    content.frames_per_second =
        static_cast<int>(std::lround(std::clamp(1e6 / recording::usual_period_us(times), 1.0, 1000.0)));
    if (images_.since_1970) content.unix_zero_us = zero_.count();
    if (!images_.color.empty()) {
      if (auto colored = describe_color(content); !colored) return fail(colored.error());
    }
    if (!settings_.intrinsics && !uses_exported_intrinsics()) {
      report_.remarks.emplace_back(
          fmt::format("no --fx given: square pixels and the nominal field of view of a Kinect are assumed, "
                      "fx = fy = {:.1f}",
                      content.camera.model.fx));
    }
    return content;
  }

  Result<void> describe_color(recording::OniContent& content) {
    const std::filesystem::path& path = images_.color.front().path;
    const auto picture = read_color(path);
    if (!picture) return fail(picture.error());
    color_size_ = size_of(picture->bgr);
    const auto color_is_odd = is_odd(path);
    if (!color_is_odd) return fail(color_is_odd.error());
    if (*color_is_odd) remark_on_odd_size("colour", color_size_);
    content.color = recording::ColorCoding::kJpeg;
    content.camera.registered = is_registered() && color_size_ == depth_size_;
    if (content.camera.registered) return {};
    if (exported_ && exported_->camera.color && has_size(exported_->camera.color->model, color_size_)) {
      content.camera.color = exported_->camera.color;
    } else {
      content.camera.color = recording::ColorCameraMetadata{camera_of(color_size_), {}};
    }
    return {};
  }

  std::string camera_name() const {
    if (!settings_.name.empty()) return settings_.name;
    if (exported_ && !exported_->camera.name.empty()) return exported_->camera.name;
    const auto folder = std::filesystem::absolute(settings_.folder).lexically_normal();
    // A path that ends with a slash has an empty last part.
    const std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
    return name.empty() ? "images" : name;
  }

  bool uses_exported_intrinsics() const {
    return exported_ && has_size(exported_->camera.model, depth_size_);
  }

  bool is_registered() const {
    return settings_.registered && (!exported_ || exported_->camera.registered) &&
           coding_ != DepthCoding::kKinectDisparity && coding_ != DepthCoding::kSwappedDisparity;
  }

  CameraModel camera_of(const Size& size) const {
    if (!settings_.intrinsics) {
      return uses_exported_intrinsics() && size == depth_size_ ? exported_->camera.model
                                                               : nominal_kinect(size.width, size.height);
    }
    const Intrinsics& given = *settings_.intrinsics;
    const CameraModel depth{depth_size_.width, depth_size_.height, given.fx,        given.fy,
                            given.cx,          given.cy,           given.distortion};
    return size == depth_size_ ? depth : scaled(depth, size);
  }

  void remark_on_odd_size(const char* what, const Size& even) {
    report_.remarks.emplace_back(
        fmt::format("{} has an odd width or height: the last column or row is left out, {}x{} remain", what,
                    even.width, even.height));
  }

  void choose_scale(const cv::Mat& first) {
    const double median = median_depth(first, coding_);
    switch (coding_) {
      case DepthCoding::kKinectDisparity:
      case DepthCoding::kSwappedDisparity:
        report_.remarks.emplace_back(
            "depth is the raw disparity of a Kinect with 11 bits: it is converted to metres by 351.3 / "
            "(1092.5 - "
            "raw), and colour is not registered");
        return;
      case DepthCoding::kSwapped:
        report_.remarks.emplace_back("depth has the two bytes of each number exchanged; this is corrected");
        break;
      case DepthCoding::kFloat:
        report_.depth_per_metre =
            settings_.depth_per_metre.value_or(median > kFarthestMedian ? kUsualPerMetre : kFloatPerMetre);
        return;
      case DepthCoding::kWhole:
        break;
    }
    const double usual = images_.has_tum_depth ? kTumPerMetre : kUsualPerMetre;
    report_.depth_per_metre =
        settings_.depth_per_metre.value_or(exported_ ? exported_->depth_per_metre : usual);
    if (settings_.depth_per_metre || exported_ || median == 0) return;
    const auto is_plausible = [&](double per_metre) {
      return median / per_metre >= kNearestRoom && median / per_metre <= kFarthestRoom;
    };
    const double other = images_.has_tum_depth ? kUsualPerMetre : kTumPerMetre;
    if (!is_plausible(report_.depth_per_metre) && is_plausible(other)) {
      report_.remarks.emplace_back(fmt::format(
          "the median depth of the first image is {:.2f} m at {:g} per metre, but {:.2f} m at {:g}: if the "
          "second is right, give --depth-scale {:g}",
          median / report_.depth_per_metre, report_.depth_per_metre, median / other, other, other));
    }
  }

  Result<void> write(recording::OniWriter& writer, const recording::ProgressReport& progress) {
    const std::size_t count = images_.depth.size() + images_.color.size();
    auto depth = images_.depth.begin();
    auto color = images_.color.begin();
    for (std::size_t done = 0; done < count; ++done) {
      const bool depth_next =
          color == images_.color.end() || (depth != images_.depth.end() && depth->time <= color->time);
      if (depth_next) {
        if (auto written = write_depth(writer, *depth); !written) return written;
        ++depth;
      } else {
        if (auto written = write_color(writer, *color); !written) return written;
        ++color;
      }
      progress(static_cast<double>(done + 1) / static_cast<double>(count));
    }
    report_.bytes = writer.bytes();
    return writer.finish();
  }

  Result<void> write_depth(recording::OniWriter& writer, const TimedImage& timed) {
    const auto image = read_depth(timed.path);
    if (!image) return fail(image.error());
    if (auto fits = check_size(timed.path, *image, depth_size_); !fits) return fits;
    if ((image->type() == CV_32FC1) != (coding_ == DepthCoding::kFloat)) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: the first depth image has 16-bit integers and this "
                                                   "one floating-point numbers, or the other "
                                                   "way round; move it to another folder",
                                                   timed.path.string()));
    }
    ++report_.depth_frames;
    return writer.write_depth(
        time_of(timed), convert_depth(*image, coding_, report_.depth_per_metre, unit_, report_.too_far));
  }

  Result<void> write_color(recording::OniWriter& writer, const TimedImage& timed) {
    const auto picture = read_color(timed.path);
    if (!picture) return fail(picture.error());
    if (auto fits = check_size(timed.path, picture->bgr, color_size_); !fits) return fits;
    ++report_.color_frames;
    if (!picture->jpeg_as_is.empty()) return writer.write_jpeg(time_of(timed), picture->jpeg_as_is);
    ColorImage color(picture->bgr.cols, picture->bgr.rows);
    cv::Mat rgb(picture->bgr.rows, picture->bgr.cols, CV_8UC3, color.data());
    cv::cvtColor(picture->bgr, rgb, cv::COLOR_BGR2RGB);
    return writer.write_color(time_of(timed), color);
  }

  const FromImagesSettings& settings_;
  const ImageFolder images_;
  const std::optional<ExportedCamera> exported_;
  const DepthUnit unit_;
  microseconds zero_{};
  DepthCoding coding_ = DepthCoding::kWhole;
  Size depth_size_, color_size_;
  FromImagesReport report_;
};

}  // namespace

Result<FromImagesReport> make_from_images(const FromImagesSettings& settings,
                                          const recording::ProgressReport& progress) {
  auto images = find_images(settings.folder, {.frames_per_second = settings.frames_per_second,
                                              .times = settings.times,
                                              .depth = settings.depth,
                                              .color = settings.color});
  if (!images) return fail(images.error());
  auto exported = read_exported_camera(settings.folder);
  if (!exported) return fail(exported.error());
  return ImageImport(settings, std::move(*images), std::move(*exported)).run(progress);
}

}  // namespace copresence::record
