// Cameras of the drivers that a user has installed for OpenNI2 (Orbbec's, for example). OpenNI2 itself looks
// only into our private folder, so this driver loads them and hands OpenNI2's calls on to the one whose
// camera it is.

#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/foreign_driver.h"
#include "capture_server/drivers/installed/driver_files.h"

namespace copresence::drivers {
namespace {

using oni::driver::DeviceBase;
using oni::driver::DriverBase;
using oni::driver::StreamBase;

class InstalledDrivers final : public DriverBase {
 public:
  explicit InstalledDrivers(OniDriverServices* services) : DriverBase(services), services_(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    if (!is_chosen(kInstalled)) return ONI_STATUS_OK;
    for (const std::string& path : installed_drivers(driver_folders(COPRESENCE_OPENNI_DRIVERS))) {
      const auto driver = ForeignDriver::load(path);
      if (!driver) continue;  // built for another system, most likely: the other cameras are none the worse
      Loaded& loaded = drivers_.emplace_back(Loaded{*driver, this});
      driver->create(services_);
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

  // OpenNI2 does not say whose streams they are: only where there is one driver they can only be its own.
  // Frames are paired by their times in any case.
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

  // A driver announces its cameras to us, so that we know whose they are; OpenNI2 hears of them as ours.
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

  OniDriverServices* services_;
  std::list<Loaded> drivers_;  // keeps its elements where they are
  std::mutex mutex_;           // of the next
  std::map<std::string, const Loaded*, std::less<>> announced_by_;
  std::map<DeviceBase*, const Loaded*> opened_by_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::InstalledDrivers)
