// The driver of simulated cameras for OpenNI2. URIs: contract/simulated_uri.h.
// Thread: OpenNI2 calls a driver from its users' threads. If a camera has a control file, one
// thread of the driver watches that file.

#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/periodic_thread.h"
#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/drivers/simulated/simulated_device.h"

namespace copresence::drivers {
namespace {

using Camera = SimulatedDevice::Camera;

constexpr std::chrono::milliseconds kWatchPeriod(50);

class SimulatedDriver final : public oni::driver::DriverBase {
 public:
  using DriverBase::DriverBase;

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    chosen_ = is_chosen(kSimulated);
    if (chosen_) tryDevice("simulated:room?camera=0");  // One camera for --list.
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
      if (!parsed->control.empty() && !watch_) watch_.emplace(kWatchPeriod, [this] { check_controls(); });
    }
    const OniDeviceInfo info = info_of(uri);
    deviceConnected(&info);
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    const auto parsed = parse_simulated_uri(uri);
    if (!parsed) return nullptr;
    std::optional<SharedProjectors> projectors;
    if (!parsed->projectors.empty()) {
      auto opened = SharedProjectors::open(parsed->projectors);
      if (!opened) return report(opened.error());
      projectors.emplace(std::move(*opened));
    }
    auto make_camera = [this, text = std::string(uri), uri = *parsed]() -> Camera {
      const auto camera = camera_of(text, uri);
      return camera ? *camera : report(camera.error());
    };
    return new SimulatedDevice(*parsed, std::move(make_camera), std::move(projectors));
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

  void shutdown() override {
    std::optional<PeriodicThread> ending;  // Joins the thread after the lock is released.
    const std::lock_guard lock(mutex_);
    ending.swap(watch_);
  }

 private:
  struct Known {
    SimulatedUri uri;
    bool announced = false;
    Camera camera;  // The pointer is null until the camera is opened.
  };

  // Stores an error's message as OpenNI2's last error.
  std::nullptr_t report(const Error& error) {
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
    const CameraModel model = simulation::kinect_model(SimulatedDevice::kWidth, SimulatedDevice::kHeight);
    auto camera = simulation::SimulatedKinect::make(world, model, poses, static_cast<std::size_t>(uri.camera),
                                                    DepthUnit::kMillimetre, uri.seed);
    if (!camera) return fail(camera.error());
    known.uri = uri;
    known.camera = std::make_shared<simulation::SimulatedKinect>(std::move(*camera));
    known.camera->precompute();
    return known.camera;
  }

  // Reports cameras whose control file appeared or disappeared. Calls OpenNI2 without mutex_,
  // because OpenNI2 may call this driver while it holds a lock of its own.
  void check_controls() {
    std::map<std::string, bool> changed;  // URIs; true if plugged in, false if unplugged.
    {
      const std::lock_guard lock(mutex_);
      for (auto& [text, known] : known_) {
        const bool is_there = read_control(known.uri.control) != Control::kUnplugged;
        if (is_there != known.announced) changed[text] = known.announced = is_there;
      }
    }
    for (const auto& [text, is_connected] : changed) {
      const OniDeviceInfo info = info_of(text);
      is_connected ? deviceConnected(&info) : deviceDisconnected(&info);
    }
  }

  bool chosen_ = false;
  std::mutex mutex_;
  std::map<std::string, Known> known_;
  std::map<std::string, std::shared_ptr<const simulation::LitScene>> worlds_;
  std::optional<PeriodicThread> watch_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::SimulatedDriver)
