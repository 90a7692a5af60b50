// A driver for the cameras of all drivers that a user has installed for OpenNI2 (Orbbec's, for
// example). OpenNI2 itself searches only this project's private folder. So this driver loads the
// others and forwards OpenNI2's calls to the driver of each camera.

#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>

#include "capture_server/drivers/contract/foreign_driver.h"
#include "capture_server/drivers/installed/driver_files.h"

namespace copresence::drivers {
namespace {

using oni::driver::DeviceBase;
using oni::driver::StreamBase;

class InstalledDrivers final : public ForeignDriverHost {
 public:
  explicit InstalledDrivers(OniDriverServices* services) : ForeignDriverHost(services, kInstalled) {}

  OniStatus load(oni::driver::DeviceConnectedCallback, oni::driver::DeviceDisconnectedCallback,
                 oni::driver::DeviceStateChangedCallback, void*) override {
    for (const std::string& path : installed_drivers(driver_folders(COPRESENCE_OPENNI_DRIVERS))) {
      const auto driver = ForeignDriver::load(path);
      if (!driver) continue;  // The library was probably built for another system.
      Loaded& loaded = drivers_.emplace_back(Loaded{*driver, this});
      driver->create(services());
      if (driver->initialize(on_connected, on_disconnected, on_changed, &loaded) != ONI_STATUS_OK)
        drivers_.pop_back();
    }
    return ONI_STATUS_OK;
  }

  OniStatus tryDevice(const char* uri) override {
    for (Loaded& loaded : drivers_) {
      if (loaded.driver.try_device(uri) != ONI_STATUS_OK) continue;
      note(uri, loaded);
      return ONI_STATUS_OK;
    }
    return ONI_STATUS_ERROR;
  }

  DeviceBase* deviceOpen(const char* uri, const char* mode) override {
    const Loaded* owner = nullptr;
    {
      const std::lock_guard lock(mutex_);
      const auto found = announced_by_.find(uri);
      if (found == announced_by_.end()) return nullptr;
      owner = found->second;
    }
    DeviceBase* const device = owner->driver.open(uri, mode);
    const std::lock_guard lock(mutex_);
    if (device) opened_by_[device] = owner;
    return device;
  }
  void deviceClose(DeviceBase* device) override {
    const Loaded* owner = nullptr;
    {
      const std::lock_guard lock(mutex_);
      const auto found = opened_by_.find(device);
      if (found == opened_by_.end()) return;
      owner = found->second;
      opened_by_.erase(found);
    }
    owner->driver.close(device);
  }

  // OpenNI2 does not say to which driver the streams belong, so hardware sync works only with a
  // single driver. Without hardware sync, frames are paired by their times.
  void* enableFrameSync(StreamBase** streams, int count) override {
    return drivers_.size() == 1 ? drivers_.front().driver.enable_sync(streams, count) : nullptr;
  }
  void disableFrameSync(void* group) override {
    if (drivers_.size() == 1) drivers_.front().driver.disable_sync(group);
  }

  void shutdown() override {
    for (const Loaded& loaded : drivers_) loaded.driver.destroy();
    drivers_.clear();
  }

 private:
  struct Loaded {
    ForeignDriver driver;
    InstalledDrivers* owner;
  };

  // An installed driver announces its cameras here. This driver stores which driver owns each
  // camera and announces it to OpenNI2.
  static void on_connected(const OniDeviceInfo* info, void* cookie) {
    Loaded& loaded = *static_cast<Loaded*>(cookie);
    loaded.owner->note(info->uri, loaded);
    loaded.owner->deviceConnected(info);
  }
  static void on_disconnected(const OniDeviceInfo* info, void* cookie) {
    static_cast<Loaded*>(cookie)->owner->deviceDisconnected(info);
  }
  static void on_changed(const OniDeviceInfo* info, int state, void* cookie) {
    static_cast<Loaded*>(cookie)->owner->deviceStateChanged(info, state);
  }

  void note(const char* uri, const Loaded& loaded) {
    const std::lock_guard lock(mutex_);
    announced_by_[uri] = &loaded;
  }

  std::list<Loaded> drivers_;  // A list keeps its elements in place.
  std::mutex mutex_;           // Guards the maps.
  std::map<std::string, const Loaded*, std::less<>> announced_by_;
  std::map<DeviceBase*, const Loaded*> opened_by_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::InstalledDrivers)
