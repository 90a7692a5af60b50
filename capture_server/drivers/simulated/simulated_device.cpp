#include "capture_server/drivers/simulated/simulated_device.h"

#include <pthread.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "capture_server/drivers/simulated/frame_clock.h"
#include "common/flow/waiting.h"
#include "simulation/sensor/frame_marker.h"
#include "simulation/sensor/kinect_depth.h"

namespace copresence::drivers {
namespace {

using std::chrono::microseconds;
using std::chrono::system_clock;

constexpr int kMaxDepth = 10000;  // A bound above all depth values.

std::int64_t now_us() {
  return std::chrono::duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

Pose rows_of(const Rigid3& pose) {
  Pose rows{};
  std::size_t next = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rows[next++] = pose.rotation(row, column);
    rows[next++] = pose.translation[row];
  }
  return rows;
}

}  // namespace

Control read_control(const std::string& path) {
  if (path.empty()) return Control::kWork;
  std::ifstream file(path);
  if (!file) return Control::kUnplugged;
  std::string word;
  file >> word;
  if (word == "stall") return Control::kStall;
  if (word == "crash") return Control::kCrash;
  if (word == "hang") return Control::kHang;
  return Control::kWork;
}

SimulatedDevice::SimulatedDevice(SimulatedUri uri, std::function<Camera()> make_camera,
                                 std::optional<SharedProjectors> projectors)
    : PushDevice(kWidth, kHeight, static_cast<int>(FrameClock::kPerSecond), kMaxDepth),
      uri_(std::move(uri)),
      make_camera_(std::move(make_camera)),
      projectors_(std::move(projectors)) {
  add_sensor(ONI_SENSOR_DEPTH, ONI_PIXEL_FORMAT_DEPTH_1_MM);
  add_sensor(ONI_SENSOR_COLOR, ONI_PIXEL_FORMAT_RGB888);
}

OniStatus SimulatedDevice::getProperty(int property, void* data, int* size) {
  if (property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) {
    const int mode = ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    return answer(&mode, sizeof(mode), data, size);
  }
  if (property == ONI_DEVICE_PROPERTY_SERIAL_NUMBER) {
    const std::string serial = "SIM" + std::to_string(uri_.camera);
    return answer(serial.c_str(), static_cast<int>(serial.size()) + 1, data, size);
  }
  if (property == kPose) {
    const Pose pose = rows_of(simulation::kinect_poses(uri_.cameras)[static_cast<std::size_t>(uri_.camera)]);
    return answer(&pose, sizeof(pose), data, size);
  }
  if (property == kProjector) {
    const int on = is_projector_on_;
    return answer(&on, sizeof(on), data, size);
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

OniStatus SimulatedDevice::setProperty(int property, const void* data, int size) {
  if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION && property != kProjector)
    return ONI_STATUS_NOT_SUPPORTED;
  const auto number = read_as<int>(data, size);
  if (!number) return ONI_STATUS_BAD_PARAMETER;
  if (property == kProjector) {
    const std::lock_guard lock(mutex_);
    is_projector_on_ = *number != 0;
    share_projector_state(!streams_.empty());
    return ONI_STATUS_OK;
  }
  return isImageRegistrationModeSupported(static_cast<OniImageRegistrationMode>(*number))
             ? ONI_STATUS_OK
             : ONI_STATUS_NOT_SUPPORTED;
}

OniBool SimulatedDevice::isImageRegistrationModeSupported(OniImageRegistrationMode mode) {
  return mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
}

OniStatus SimulatedDevice::get_of(PushStream& stream, int property, void* data, int* size) {
  if (property != kDepthOfDisparity || stream.type() != ONI_SENSOR_DEPTH) return ONI_STATUS_NOT_SUPPORTED;
  static const std::vector<std::uint16_t> levels = simulation::kinect_levels(DepthUnit::kMillimetre);
  return answer(levels.data(), static_cast<int>(levels.size() * sizeof(levels[0])), data, size);
}

OniStatus SimulatedDevice::begin(PushStream& stream) {
  const std::lock_guard lock(mutex_);
  if (!camera_) camera_ = make_camera_();
  if (!camera_) return ONI_STATUS_ERROR;
  streams_.push_back(&stream);
  share_projector_state(true);
  if (!thread_.joinable())
    thread_ = std::jthread([this](const std::stop_token& stop) { create_frames(stop); });
  return ONI_STATUS_OK;
}

void SimulatedDevice::end(PushStream& stream) {
  std::jthread ending;  // Joins the thread after the lock is released.
  const std::lock_guard lock(mutex_);
  streams_.remove(&stream);
  if (!streams_.empty()) return;
  share_projector_state(false);
  ending = std::move(thread_);
}

Lens SimulatedDevice::lens_of(OniSensorType) const {
  const CameraModel model = simulation::kinect_model(kWidth, kHeight);
  const auto angle = [](int size, double focal) {
    return static_cast<float>(2 * std::atan(0.5 * size / focal));
  };
  return {angle(model.width, model.fx), angle(model.height, model.fy),
          Intrinsics{model.fx, model.fy, model.cx, model.cy}};
}

// Shows the other cameras of the world whether this projector is on. The projector is off while the
// camera does not run. Requires mutex_.
void SimulatedDevice::share_projector_state(bool is_running) {
  if (projectors_) projectors_->set(static_cast<std::size_t>(uri_.camera), is_running && is_projector_on_);
}

simulation::Projectors SimulatedDevice::projectors_on() const {
  simulation::Projectors on = projectors_ ? projectors_->on() : simulation::Projectors().set();
  on[static_cast<std::size_t>(uri_.camera)] = is_projector_on_;
  return on;
}

// Sends no frames while the camera is unplugged. The driver reports that state to OpenNI2.
void SimulatedDevice::create_frames(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "simulated");
  FrameClock clock;
  while (!stop.stop_requested()) {
    const std::int64_t frame = clock.next(now_us());
    const std::int64_t instant_us = FrameClock::instant_us(frame);
    wait_for(microseconds(instant_us - now_us()), stop);
    if (stop.stop_requested()) return;
    const Control control = read_control(uri_.control);
    if (control == Control::kCrash) std::abort();
    while (control == Control::kHang) std::this_thread::sleep_for(std::chrono::hours(1));
    if (control != Control::kWork) continue;
    camera_->set_projectors(projectors_on());
    send_frame(static_cast<std::uint64_t>(frame), static_cast<std::uint64_t>(instant_us),
               static_cast<int>(clock.index()));
  }
}

// Creates both pictures before it sends one, so that the second one follows at once.
void SimulatedDevice::send_frame(std::uint64_t number, std::uint64_t timestamp_us, int index) {
  auto pictures = next_pictures();
  for (auto& [type, picture] : pictures) {
    if (type == ONI_SENSOR_DEPTH) {
      camera_->capture_live_depth(number, picture.pixels<std::uint16_t>());
    } else {
      const auto pixels = picture.pixels<Rgb8>();
      camera_->capture_live_color(number, pixels);
      if (uri_.marker) simulation::draw_marker(static_cast<std::uint32_t>(number), pixels, kWidth);
    }
  }
  for (auto& [type, picture] : pictures) picture.send(timestamp_us, index);
}

// A picture keeps its stream alive, so the lock is not needed after this function. The lock must
// not be held while pictures are sent, because OpenNI2 then takes a lock of its own.
std::vector<std::pair<OniSensorType, PushStream::Picture>> SimulatedDevice::next_pictures() {
  const std::lock_guard lock(mutex_);
  std::vector<std::pair<OniSensorType, PushStream::Picture>> pictures;
  for (PushStream* stream : streams_)
    if (auto picture = stream->next_picture()) pictures.emplace_back(stream->type(), std::move(*picture));
  return pictures;
}

}  // namespace copresence::drivers
