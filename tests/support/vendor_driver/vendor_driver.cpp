// An OpenNI2 driver for tests, like that of a camera vendor. It does not know this project, and
// reports one camera, 2bc5/0401@1/7, with depth only. When it is loaded, it appends its name to the
// file that COPRESENCE_VENDOR_LOG names.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>

#include "capture_server/drivers/contract/periodic_thread.h"
#include "capture_server/drivers/contract/push_device.h"

namespace {

using namespace copresence::drivers;

constexpr const char* kUri = "2bc5/0401@1/7";

class VendorDevice final : public PushDevice {
 public:
  VendorDevice() : PushDevice(320, 240, 30, 10'000) {
    add_sensor(ONI_SENSOR_DEPTH, ONI_PIXEL_FORMAT_DEPTH_1_MM);
  }

  OniStatus begin(PushStream& stream) override {
    sender_.emplace(std::chrono::milliseconds(33), [this, &stream] {
      if (auto picture = stream.next_picture()) {
        for (auto& pixel : picture->pixels<std::uint16_t>()) pixel = 1500;
        ++index_;
        picture->send(static_cast<std::uint64_t>(index_) * 33'333, index_);
      }
    });
    return ONI_STATUS_OK;
  }
  void end(PushStream&) override { sender_.reset(); }

 private:
  Lens lens_of(OniSensorType) const override { return {1.0f, 0.8f, {}}; }

  std::optional<PeriodicThread> sender_;
  int index_ = 0;
};

class VendorDriver final : public oni::driver::DriverBase {
 public:
  explicit VendorDriver(OniDriverServices* services) : DriverBase(services) {
    if (const char* log = std::getenv("COPRESENCE_VENDOR_LOG"))
      std::ofstream(log, std::ios::app) << "loaded\n";
  }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    OniDeviceInfo info{};
    std::snprintf(info.uri, sizeof(info.uri), "%s", kUri);
    std::snprintf(info.vendor, sizeof(info.vendor), "Vendor");
    std::snprintf(info.name, sizeof(info.name), "Depth Camera");
    deviceConnected(&info);
    return ONI_STATUS_OK;
  }
  OniStatus tryDevice(const char*) override { return ONI_STATUS_ERROR; }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    return std::strcmp(uri, kUri) == 0 ? new VendorDevice : nullptr;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}
};

}  // namespace

ONI_EXPORT_DRIVER(VendorDriver)
