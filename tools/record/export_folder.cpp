#include "tools/record/export_folder.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/text/text_file.h"

namespace copresence::record {
namespace {

constexpr double kTumPerMetre = 5000, kMillimetresPerMetre = 1000, kTenthsPerMetre = 10'000;
constexpr const char* kDepthPerMetre = "depth_per_metre";

std::string seconds(std::chrono::microseconds time) {
  return fmt::format("{}.{:06}", time.count() / 1'000'000, time.count() % 1'000'000);
}

std::string frame_name(std::size_t number, const char* ending) {
  return fmt::format("frame-{:06}.{}", number, ending);
}

Result<void> write_image(const std::filesystem::path& path, const cv::Mat& image) {
  if (cv::imwrite(path.string(), image)) return {};
  return fail(ErrorCode::kUnavailable,
              fmt::format("{}: cannot be written; is the disk full?", path.string()));
}

Result<void> write_bytes(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) return {};
  return fail(ErrorCode::kUnavailable,
              fmt::format("{}: cannot be written; is the disk full?", path.string()));
}

}  // namespace

Result<ExportFolder> ExportFolder::create(const std::filesystem::path& path, ExportFormat format,
                                          recording::CameraMetadata camera) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  const bool is_empty = !error && std::filesystem::is_empty(path, error);
  if (error) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: the folder cannot be made: {}", path.string(), error.message()));
  }
  if (!is_empty) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: is not empty, and nothing in it is overwritten; give a new folder", path.string()));
  }
  return ExportFolder(path, format, std::move(camera));
}

ExportFolder::ExportFolder(std::filesystem::path path, ExportFormat format, recording::CameraMetadata camera)
    : path_(std::move(path)), format_(format), camera_(std::move(camera)) {
  if (format_ != ExportFormat::kTum) return;
  std::error_code ignored;  // A missing folder makes the first image fail.
  std::filesystem::create_directory(path_ / "depth", ignored);
  std::filesystem::create_directory(path_ / "rgb", ignored);
  depth_list_.open(path_ / "depth.txt");
  color_list_.open(path_ / "rgb.txt");
  depth_list_ << "# timestamp filename\n";
  color_list_ << "# timestamp filename\n";
}

double ExportFolder::depth_per_metre() const {
  // A factor of 5000 would lose the last digit of depth in tenths of a millimetre.
  if (camera_.unit == DepthUnit::k100Micrometres) return kTenthsPerMetre;
  return format_ == ExportFormat::kTum ? kTumPerMetre : kMillimetresPerMetre;
}

Result<void> ExportFolder::add_depth(std::chrono::microseconds time, const DepthImage& image,
                                     const std::optional<Rigid3>& world_from_camera) {
  const cv::Mat depth(image.height(), image.width(), CV_16UC1, const_cast<std::uint16_t*>(image.data()));
  cv::Mat stored;
  depth.convertTo(stored, CV_16UC1, depth_per_metre() * metres_per_unit(camera_.unit));
  // Depth beyond 16 bits becomes a hole. 65535 is a hole in 7-Scenes.
  stored.setTo(0, stored == 65535);
  std::string name;
  if (format_ == ExportFormat::kTum) {
    name = "depth/" + seconds(time) + ".png";
    depth_list_ << seconds(time) << ' ' << name << '\n';
  } else {
    name = frame_name(depth_images_, "depth.png");
  }
  ++depth_images_;
  if (auto written = write_image(path_ / name, stored); !written) return written;
  return world_from_camera ? write_pose(time, *world_from_camera) : Result<void>();
}

Result<void> ExportFolder::write_pose(std::chrono::microseconds time, const Rigid3& world_from_camera) {
  const Eigen::Vector3d& t = world_from_camera.translation;
  if (format_ == ExportFormat::kTum) {
    if (!poses_.is_open()) {
      poses_.open(path_ / "groundtruth.txt");
      poses_ << "# timestamp tx ty tz qx qy qz qw\n";
    }
    const Eigen::Quaterniond q(world_from_camera.rotation);
    poses_ << fmt::format("{} {} {} {} {} {} {} {}\n", seconds(time), t.x(), t.y(), t.z(), q.x(), q.y(),
                          q.z(), q.w());
    return {};
  }
  std::string text;
  for (int row = 0; row < 3; ++row) {
    const auto r = world_from_camera.rotation.row(row);
    text += fmt::format("{}\t{}\t{}\t{}\n", r.x(), r.y(), r.z(), t[row]);
  }
  text += "0\t0\t0\t1\n";
  return write_bytes(path_ / frame_name(depth_images_ - 1, "pose.txt"),
                     {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::string ExportFolder::note_color(std::chrono::microseconds time, const char* extension) {
  ++color_images_;
  if (format_ == ExportFormat::k7Scenes)
    return frame_name(depth_images_ - 1, (std::string("color.") + extension).c_str());
  const std::string name = fmt::format("rgb/{}.{}", seconds(time), extension);
  color_list_ << seconds(time) << ' ' << name << '\n';
  return name;
}

Result<void> ExportFolder::add_color(std::chrono::microseconds time, const ColorImage& image) {
  const cv::Mat rgb(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  return write_image(path_ / note_color(time, "png"), bgr);
}

Result<void> ExportFolder::add_color(std::chrono::microseconds time, std::span<const std::uint8_t> jpeg) {
  return write_bytes(path_ / note_color(time, "jpg"), jpeg);
}

Result<void> ExportFolder::finish() {
  for (std::ofstream* list : {&depth_list_, &color_list_, &poses_}) {
    if (list->is_open()) list->close();
    if (!*list)
      return fail(ErrorCode::kUnavailable,
                  fmt::format("{}: a list cannot be written; is the disk full?", path_.string()));
  }
  if (color_images_ == 0 && format_ == ExportFormat::kTum) {
    std::error_code ignored;  // from-images would miss the images of an empty list.
    std::filesystem::remove(path_ / "rgb.txt", ignored);
    std::filesystem::remove(path_ / "rgb", ignored);
  }
  auto json = nlohmann::ordered_json::parse(recording::to_json(camera_));
  json[kDepthPerMetre] = depth_per_metre();
  const std::string text = json.dump(2) + '\n';
  return write_bytes(path_ / kCameraFile, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Result<std::optional<ExportedCamera>> read_exported_camera(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kCameraFile;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  const auto text = text::read_text_file(path, "a camera's data");
  if (!text) return fail(text.error());
  auto camera = recording::parse_camera_metadata(*text);
  if (!camera) return fail(camera.error().code, fmt::format("{}: {}", path.string(), camera.error().what));
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const auto scale = json.find(kDepthPerMetre);
  if (scale == json.end() || !scale->is_number() || !(*scale >= 1.0) || !(*scale <= 65535.0)) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{}: \"{}\" must be a number from 1 to 65535", path.string(), kDepthPerMetre));
  }
  return ExportedCamera{std::move(*camera), scale->get<double>()};
}

}  // namespace copresence::record
