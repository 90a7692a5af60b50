#include "capture_server/sensor/open_ni.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <tuple>

#include "capture_server/drivers/contract/device_properties.h"
#include "capture_server/drivers/contract/driver_choice.h"
#include "common/flow/cpu_starvation.h"

namespace copresence::sensor {

openni::Status OpenNiSession::initialize(std::string_view choice) {
  ::setenv(drivers::kChoiceVariable, std::string(choice).c_str(), 1);
  return openni::OpenNI::initialize();
}

void let_threads_leave() {
  using std::chrono::milliseconds;
  constexpr milliseconds kLeaves(50), kHardlyAnything(5);
  constexpr int kMostTimes = 8;
  flow::CpuStarvation starvation(::getpid());
  auto before = starvation.look();
  for (int i = 0; i < kMostTimes; ++i) {
    std::this_thread::sleep_for(kLeaves);
    const auto now = starvation.look();
    if (now - before < kHardlyAnything) return;
    before = now;
  }
}

std::string last_open_ni_error() {
  std::string text = openni::OpenNI::getExtendedError();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t' || c == '\r'; }, ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  text.erase(0, text.find_first_not_of(' '));
  return text.empty() ? "no reason given" : text;
}

bool is_usable(const openni::VideoMode& mode, bool is_depth) {
  const openni::PixelFormat format = mode.getPixelFormat();
  const bool known =
      is_depth ? format == openni::PIXEL_FORMAT_DEPTH_1_MM || format == openni::PIXEL_FORMAT_DEPTH_100_UM
               : format == openni::PIXEL_FORMAT_RGB888;
  const auto sane = [](int size) { return size >= 2 && size <= 4096 && size % 2 == 0; };
  return known && sane(mode.getResolutionX()) && sane(mode.getResolutionY());
}

std::optional<openni::VideoMode> choose_mode(const openni::SensorInfo& sensor, bool is_depth, int width,
                                             int height) {
  std::optional<openni::VideoMode> chosen;
  std::tuple<int, int, int> least;
  const auto& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    const openni::VideoMode& mode = modes[i];
    if (!is_usable(mode, is_depth)) continue;
    const std::tuple distance{
        std::abs(mode.getResolutionX() - width) + std::abs(mode.getResolutionY() - height),
        std::abs(mode.getFps() - 30), mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM ? 1 : 0};
    if (!chosen || distance < least) {
      chosen = mode;
      least = distance;
    }
  }
  return chosen;
}

CameraModel camera_of(const openni::VideoStream& stream) {
  const openni::VideoMode mode = stream.getVideoMode();
  drivers::Intrinsics known;
  int size = sizeof(known);
  if (stream.getProperty(drivers::kIntrinsics, &known, &size) == openni::STATUS_OK && size == sizeof(known)) {
    const CameraModel model{
        mode.getResolutionX(), mode.getResolutionY(), known[0], known[1], known[2], known[3], {}};
    if (check(model)) return model;
  }
  const double horizontal = stream.getHorizontalFieldOfView(), vertical = stream.getVerticalFieldOfView();
  const auto sane = [](double angle) { return angle > 0.01 && angle < 3.13; };
  if (!sane(horizontal) || !sane(vertical))
    return nominal_kinect(mode.getResolutionX(), mode.getResolutionY());
  return camera_of_sensor(mode.getResolutionX(), mode.getResolutionY(), horizontal, vertical);
}

std::optional<Rigid3> pose_of(const openni::Device& device) {
  drivers::Pose rows;
  int size = sizeof(rows);
  if (device.getProperty(drivers::kPose, &rows, &size) != openni::STATUS_OK || size != sizeof(rows))
    return std::nullopt;
  Rigid3 pose;
  for (std::size_t row = 0; row < 3; ++row) {
    const auto i = static_cast<Eigen::Index>(row);
    for (std::size_t column = 0; column < 3; ++column)
      pose.rotation(i, static_cast<Eigen::Index>(column)) = rows[4 * row + column];
    pose.translation[i] = rows[4 * row + 3];
  }
  return pose.is_rigid() ? std::optional(pose) : std::nullopt;
}

std::vector<std::uint16_t> levels_of(const openni::VideoStream& depth) {
  // Some drivers require exactly the size of their table, which is 2048 entries in all drivers
  // seen. Other drivers ignore the given size, so the buffer has room for the largest table.
  constexpr std::size_t kUsual = 2048, kLargest = 65536;
  std::vector<std::uint16_t> levels(kLargest);
  for (const std::size_t entries : {kUsual, kLargest}) {
    int bytes = static_cast<int>(entries * sizeof(levels[0]));
    if (depth.getProperty(drivers::kDepthOfDisparity, levels.data(), &bytes) != openni::STATUS_OK) continue;
    levels.resize(std::clamp<std::size_t>(static_cast<std::size_t>(std::max(bytes, 0)) / sizeof(levels[0]), 0,
                                          kLargest));
    std::erase(levels, std::uint16_t{0});
    std::sort(levels.begin(), levels.end());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    return levels;
  }
  return {};
}

bool is_whole(const openni::VideoFrameRef& frame, const CameraModel& camera, int bytes_per_pixel) {
  const int row_bytes = camera.width * bytes_per_pixel;
  return frame.isValid() && frame.getData() && frame.getWidth() == camera.width &&
         frame.getHeight() == camera.height && frame.getStrideInBytes() >= row_bytes &&
         frame.getDataSize() == frame.getStrideInBytes() * camera.height;
}

void copy_depth(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into) {
  into.depth.resize(camera.width, camera.height);
  into.state.resize(camera.width, camera.height);
  const auto* row = static_cast<const std::uint8_t*>(frame.getData());
  for (int y = 0; y < camera.height; ++y, row += frame.getStrideInBytes()) {
    const auto depth = into.depth.row(y);
    const auto state = into.state.row(y);
    std::memcpy(depth.data(), row, depth.size_bytes());
    std::transform(depth.begin(), depth.end(), state.begin(),
                   [](std::uint16_t z) { return z ? DepthState::kMeasured : DepthState::kHole; });
  }
}

void copy_color(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into) {
  ColorImage& color = into.color.emplace();
  color.resize(camera.width, camera.height);
  const auto* row = static_cast<const std::uint8_t*>(frame.getData());
  for (int y = 0; y < camera.height; ++y, row += frame.getStrideInBytes()) {
    const auto pixels = color.row(y);
    std::memcpy(pixels.data(), row, pixels.size_bytes());
  }
}

}  // namespace copresence::sensor
