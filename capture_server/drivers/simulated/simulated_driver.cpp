// Simulated Kinects as cameras of OpenNI2: simulated:WORLD?camera=N, see contract/simulated_uri.h. 640x480 at 30 frames a second,
// depth in 1 mm registered to colour, time from the system clock.
//
// One thread per started device makes its frames; one thread per driver watches control files, where there are any.

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/push_device.h"
#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/drivers/contract/watch.h"
#include "capture_server/drivers/simulated/frame_clock.h"
#include "capture_server/drivers/simulated/shared_projectors.h"
#include "common/flow/waiting.h"
#include "simulation/sensor/frame_marker.h"
#include "simulation/sensor/kinect_depth.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::drivers {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::system_clock;

constexpr int kWidth = 640, kHeight = 480;
constexpr int kMaxDepth = 10000;  // greater than every pixel's
constexpr milliseconds kWatchEvery(50);

// A camera at its place with everything traced that it will see. Kept when its device is closed: plugging it in again
// takes no second.
using Camera = std::shared_ptr<simulation::SimulatedKinect>;

// Read from the control file of a camera, for tests of what happens when cameras fail.
enum class Control {
  kWork,       // no file was named, or its first word is none of the following
  kUnplugged,  // there is no such file
  kStall,      // "stall": no frames, and no error
  kCrash,      // "crash": the driver ends its process
  kHang,       // "hang": the driver never returns
};

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

Lens lens_through(const CameraModel& model) {
  const auto angle = [](int size, double focal) {
    return static_cast<float>(2 * std::atan(0.5 * size / focal));
  };
  return {angle(model.width, model.fx), angle(model.height, model.fy),
          Intrinsics{model.fx, model.fy, model.cx, model.cy}};
}

class SimulatedDevice final : public PushDevice {
 public:
  /// `make_camera` is called when the first stream starts: it takes a second where it has not been called before.
  /// `air`: where the projectors of the room meet, if anywhere.
  SimulatedDevice(SimulatedUri uri, std::function<Camera()> make_camera, std::optional<SharedProjectors> air)
      : PushDevice(kWidth, kHeight, static_cast<int>(FrameClock::kPerSecond), kMaxDepth),
        uri_(std::move(uri)),
        make_camera_(std::move(make_camera)),
        air_(std::move(air)) {
    add_sensor(ONI_SENSOR_DEPTH, ONI_PIXEL_FORMAT_DEPTH_1_MM);
    add_sensor(ONI_SENSOR_COLOR, ONI_PIXEL_FORMAT_RGB888);
  }

  OniStatus getProperty(int property, void* data, int* size) override {
    if (property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) {
      const int mode = ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
      return answer(&mode, sizeof(mode), data, size);
    }
    if (property == ONI_DEVICE_PROPERTY_SERIAL_NUMBER) {
      const std::string serial = "SIM" + std::to_string(uri_.camera);
      return answer(serial.c_str(), static_cast<int>(serial.size()) + 1, data, size);
    }
    if (property == kPose) {
      const Pose pose =
          rows_of(simulation::kinect_poses(uri_.cameras)[static_cast<std::size_t>(uri_.camera)]);
      return answer(&pose, sizeof(pose), data, size);
    }
    if (property == kProjector) {
      const int on = projector_;
      return answer(&on, sizeof(on), data, size);
    }
    return ONI_STATUS_NOT_SUPPORTED;
  }
  OniStatus setProperty(int property, const void* data, int size) override {
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION && property != kProjector)
      return ONI_STATUS_NOT_SUPPORTED;
    const auto number = read_as<int>(data, size);
    if (!number) return ONI_STATUS_BAD_PARAMETER;
    if (property == kProjector) {
      const std::lock_guard lock(mutex_);
      projector_ = *number != 0;
      shine(!streams_.empty());
      return ONI_STATUS_OK;
    }
    return isImageRegistrationModeSupported(static_cast<OniImageRegistrationMode>(*number))
               ? ONI_STATUS_OK
               : ONI_STATUS_NOT_SUPPORTED;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  }

  OniStatus get_of(PushStream& stream, int property, void* data, int* size) override {
    if (property != kDepthOfDisparity || stream.type() != ONI_SENSOR_DEPTH) return ONI_STATUS_NOT_SUPPORTED;
    static const std::vector<std::uint16_t> levels = simulation::kinect_levels(DepthUnit::kMillimetre);
    return answer(levels.data(), static_cast<int>(levels.size() * sizeof(levels[0])), data, size);
  }

  OniStatus begin(PushStream& stream) override {
    const std::lock_guard lock(mutex_);
    if (!camera_) camera_ = make_camera_();
    if (!camera_) return ONI_STATUS_ERROR;
    streams_.push_back(&stream);
    shine(true);
    if (!thread_.joinable())
      thread_ = std::jthread([this](const std::stop_token& stop) { take_frames(stop); });
    return ONI_STATUS_OK;
  }

  void end(PushStream& stream) override {
    std::jthread ending;
    {
      const std::lock_guard lock(mutex_);
      streams_.remove(&stream);
      if (!streams_.empty()) return;
      shine(false);
      ending = std::move(thread_);
    }
  }  // joins where it was the last

 private:
  Lens lens_of(OniSensorType) const override {
    return lens_through(simulation::kinect_model(kWidth, kHeight));
  }

  // With mutex_ held: tells the room whether this projector shines, which it does only while the camera runs.
  void shine(bool runs) {
    if (air_) air_->set(static_cast<std::size_t>(uri_.camera), runs && projector_);
  }

  // The room's projectors at this moment.
  simulation::Projectors shining() const {
    simulation::Projectors on = air_ ? air_->shining() : simulation::Projectors().set();
    on[static_cast<std::size_t>(uri_.camera)] = projector_;
    return on;
  }

  // Frames end when the camera is unplugged; the driver's watch tells OpenNI2.
  void take_frames(const std::stop_token& stop) {
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
      camera_->set_projectors(shining());
      push_all(static_cast<std::uint64_t>(frame), static_cast<std::uint64_t>(instant_us),
               static_cast<int>(clock.index()));
    }
  }

  // Both pictures are made before one is sent: who waits for one soon has the other.
  void push_all(std::uint64_t number, std::uint64_t timestamp_us, int index) {
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

  // A stream of which there is a picture does not leave, so the lock ends here: OpenNI2 takes its own to be handed one.
  std::vector<std::pair<OniSensorType, PushStream::Picture>> next_pictures() {
    const std::lock_guard lock(mutex_);
    std::vector<std::pair<OniSensorType, PushStream::Picture>> pictures;
    for (PushStream* stream : streams_)
      if (auto picture = stream->next_picture()) pictures.emplace_back(stream->type(), std::move(*picture));
    return pictures;
  }

  const SimulatedUri uri_;
  const std::function<Camera()> make_camera_;
  std::optional<SharedProjectors> air_;
  std::atomic<bool> projector_ = true;
  Camera camera_;
  std::mutex mutex_;
  std::list<PushStream*> streams_;  // started ones
  std::jthread thread_;
};

class SimulatedDriver final : public oni::driver::DriverBase {
 public:
  using DriverBase::DriverBase;

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    chosen_ = is_chosen(kSimulated);
    if (chosen_) tryDevice("simulated:room?camera=0");  // so that lists show that there is one
    return ONI_STATUS_OK;
  }

  OniStatus tryDevice(const char* uri) override {
    if (!chosen_ || !uri || std::strlen(uri) >= ONI_MAX_STR) return ONI_STATUS_ERROR;
    const auto parsed = parse_simulated_uri(uri);
    if (!parsed || read_control(parsed->control) == Control::kUnplugged) return ONI_STATUS_ERROR;
    {
      const std::lock_guard lock(mutex_);
      Known& known = known_[uri];
      known.uri = *parsed;
      if (known.announced) return ONI_STATUS_OK;
      known.announced = true;
      if (!parsed->control.empty() && !watch_) watch_.emplace(kWatchEvery, [this] { look_at_controls(); });
    }
    const OniDeviceInfo info = info_of(uri);
    deviceConnected(&info);
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    const auto parsed = parse_simulated_uri(uri);
    if (!parsed) return nullptr;
    std::optional<SharedProjectors> air;
    if (!parsed->projectors.empty()) {
      auto opened = SharedProjectors::open(parsed->projectors);
      if (!opened) return explain(opened.error());
      air.emplace(std::move(*opened));
    }
    auto make_camera = [this, text = std::string(uri), uri = *parsed]() -> Camera {
      const auto camera = camera_of(text, uri);
      return camera ? *camera : explain(camera.error());
    };
    return new SimulatedDevice(*parsed, std::move(make_camera), std::move(air));
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

  void shutdown() override {
    std::optional<Watch> ending;  // joins when the lock is gone
    const std::lock_guard lock(mutex_);
    ending.swap(watch_);
  }

 private:
  struct Known {
    SimulatedUri uri;
    bool announced = false;
    Camera camera;  // once it was opened
  };

  // The sentence into OpenNI2's last error.
  std::nullptr_t explain(const Error& error) {
    getServices().errorLoggerAppend("%s", error.what.c_str());
    return nullptr;
  }

  static OniDeviceInfo info_of(const std::string& uri) {
    OniDeviceInfo info{};
    std::snprintf(info.uri, sizeof(info.uri), "%s", uri.c_str());
    std::snprintf(info.vendor, sizeof(info.vendor), "Copresence");
    std::snprintf(info.name, sizeof(info.name), "simulated Kinect");
    return info;
  }

  Result<Camera> camera_of(const std::string& text, const SimulatedUri& uri) {
    const std::lock_guard lock(mutex_);
    Known& known = known_[text];
    if (known.camera) return known.camera;
    auto& world = worlds_[uri.world];
    if (!world) {
      auto made = simulation::LitScene::of_world(uri.world);
      if (!made) return fail(made.error());
      world = std::make_shared<const simulation::LitScene>(std::move(*made));
    }
    const auto poses = simulation::kinect_poses(uri.cameras);
    auto camera = simulation::SimulatedKinect::make(world, simulation::kinect_model(kWidth, kHeight), poses,
                                                    static_cast<std::size_t>(uri.camera),
                                                    DepthUnit::kMillimetre, uri.seed);
    if (!camera) return fail(camera.error());
    known.uri = uri;
    known.camera = std::make_shared<simulation::SimulatedKinect>(std::move(*camera));
    known.camera->precompute();
    return known.camera;
  }

  // Tells OpenNI2 of cameras whose control file came or went. It is told without our lock, since it may be asking us
  // something under its own.
  void look_at_controls() {
    std::map<std::string, bool> told;  // whether it came or went
    {
      const std::lock_guard lock(mutex_);
      for (auto& [text, known] : known_) {
        const bool is_there = read_control(known.uri.control) != Control::kUnplugged;
        if (is_there != known.announced) told[text] = known.announced = is_there;
      }
    }
    for (const auto& [text, came] : told) {
      const OniDeviceInfo info = info_of(text);
      came ? deviceConnected(&info) : deviceDisconnected(&info);
    }
  }

  bool chosen_ = false;
  std::mutex mutex_;
  std::map<std::string, Known> known_;
  std::map<std::string, std::shared_ptr<const simulation::LitScene>> worlds_;
  std::optional<Watch> watch_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::SimulatedDriver)
