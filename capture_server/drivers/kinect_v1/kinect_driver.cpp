// The driver of Kinect v1 cameras for OpenNI2, by Debian's libfreenect. A camera's URI contains its
// serial number, freenect://A00366..., and does not depend on its place on the bus. Cameras may be
// plugged in and out, and a failing transfer counts as unplugged.
// Thread: one thread watches the bus, and each open device has its own thread.

#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/periodic_thread.h"
#include "capture_server/drivers/kinect_v1/kinect_device.h"

namespace copresence::drivers {
namespace {

constexpr std::string_view kScheme = "freenect://";
constexpr std::chrono::milliseconds kWatchEvery(200);
constexpr std::uint16_t kMicrosoft = 0x045e, kKinectCamera = 0x02ae;

class KinectDriver final : public oni::driver::DriverBase {
 public:
  using DriverBase::DriverBase;

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    if (!is_chosen(kKinectV1)) return ONI_STATUS_OK;
    bus_ = make_freenect_context(FREENECT_DEVICE_CAMERA);
    if (!bus_) return ONI_STATUS_OK;  // A machine without USB may have other cameras.
    look_at_bus();
    watch_.emplace(kWatchEvery, [this] { watch(); });
    return ONI_STATUS_OK;
  }

  OniStatus tryDevice(const char* uri) override {
    if (!bus_ || !uri || !std::string_view(uri).starts_with(kScheme)) return ONI_STATUS_ERROR;
    look_at_bus();
    const std::lock_guard lock(mutex_);
    const auto found = announced_.find(serial_of(uri));
    return found != announced_.end() && found->second ? ONI_STATUS_OK : ONI_STATUS_ERROR;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    const std::string serial = serial_of(uri);
    auto opened = KinectDevice::open(
        serial, [this, serial] { lose(serial); },
        [this](const std::string& why) { getServices().errorLoggerAppend("%s", why.c_str()); });
    if (opened) return opened->release();
    getServices().errorLoggerAppend("%s", opened.error().what.c_str());
    return nullptr;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

  void shutdown() override {
    watch_.reset();
    bus_.reset();
  }

 private:
  static std::string serial_of(std::string_view uri) {
    return std::string(uri.substr(std::min(kScheme.size(), uri.size())));
  }

  static OniDeviceInfo info_of(const std::string& serial) {
    OniDeviceInfo info{};
    std::snprintf(info.uri, sizeof(info.uri), "%s%s", std::string(kScheme).c_str(), serial.c_str());
    std::snprintf(info.vendor, sizeof(info.vendor), "Microsoft");
    std::snprintf(info.name, sizeof(info.name), "Kinect");
    info.usbVendorId = kMicrosoft;
    info.usbProductId = kKinectCamera;
    return info;
  }

  // Calls OpenNI2 without mutex_, because OpenNI2 may hold a lock when it calls this driver.
  void look_at_bus() {
    std::map<std::string, bool> told;  // Serial numbers; true if plugged in, false if out.
    {
      const std::lock_guard lock(mutex_);
      devices_seen_ = freenect_num_devices(bus_.get());
      lost_any_ = false;
      const auto listed = list_serials(*bus_);
      if (!listed) return;
      const std::set<std::string> here(listed->begin(), listed->end());
      for (auto& [serial, announced] : announced_) {
        if (announced && !here.contains(serial)) told[serial] = announced = false;
      }
      for (const std::string& serial : here) {
        bool& announced = announced_[serial];
        if (!announced) told[serial] = announced = true;
      }
    }
    for (const auto& [serial, came] : told) tell(serial, came);
  }

  void tell(const std::string& serial, bool came) {
    const OniDeviceInfo info = info_of(serial);
    came ? deviceConnected(&info) : deviceDisconnected(&info);
  }

  // This function is called if an open device's transfers failed. If the device is still there, the
  // next look_at_bus() announces it again.
  void lose(const std::string& serial) {
    {
      const std::lock_guard lock(mutex_);
      lost_any_ = true;
      bool& announced = announced_[serial];
      if (!announced) return;
      announced = false;
    }
    tell(serial, false);
  }

  // Counts the devices, which is cheap. Serial numbers are read only if the count changed, because
  // that opens every device.
  void watch() {
    std::unique_lock lock(mutex_);
    const bool changed = lost_any_ || freenect_num_devices(bus_.get()) != devices_seen_;
    lock.unlock();
    if (changed) look_at_bus();
  }

  std::mutex mutex_;
  FreenectContext bus_;                    // For enumerating devices only.
  std::map<std::string, bool> announced_;  // By serial number.
  int devices_seen_ = 0;
  bool lost_any_ = false;
  std::optional<PeriodicThread> watch_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::KinectDriver)
