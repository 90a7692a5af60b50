#include "capture_server/diagnosis/device_facts.h"

#include <cstdlib>
#include <tuple>

#include "capture_server/drivers/contract/device_properties.h"
#include "common/frame/camera_model.h"

namespace copresence::sensor {

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
    const CameraModel told{
        mode.getResolutionX(), mode.getResolutionY(), known[0], known[1], known[2], known[3], {}};
    if (check(told)) return told;
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

}  // namespace copresence::sensor
