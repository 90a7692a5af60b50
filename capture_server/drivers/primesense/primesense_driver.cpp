// PrimeSense and Asus Xtion cameras by Debian's own PS1080 driver, which is loaded only where it is chosen: it takes
// up to 0.4 s to leave. Devices and streams are PS1080's own objects; OpenNI2's driver interface gives them the same
// virtual functions wherever they come from.

#include <dlfcn.h>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/open_ni_driver.h"

namespace copresence::drivers {
namespace {

using oni::driver::DeviceBase;
using oni::driver::DriverBase;
using oni::driver::StreamBase;

constexpr const char* kPs1080 = COPRESENCE_OPENNI_DRIVERS "/libPS1080.so.0";

class PrimeSenseDriver final : public DriverBase {
 public:
  explicit PrimeSenseDriver(OniDriverServices* services) : DriverBase(services), services_(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    if (!is_chosen(kPrimeSense)) return ONI_STATUS_OK;
    // Stays loaded: its threads have been seen inside it after it said that it was done.
    library_ = ::dlopen(kPs1080, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!library_) return ONI_STATUS_OK;  // a machine without it has no such camera, and may have others
    const auto create = find<void (*)(OniDriverServices*)>("oniDriverCreate");
    const auto begin =
        find<OniStatus (*)(oni::driver::DeviceConnectedCallback, oni::driver::DeviceDisconnectedCallback,
                           oni::driver::DeviceStateChangedCallback, void*)>("oniDriverInitialize");
    destroy_ = find<void (*)()>("oniDriverDestroy");
    try_device_ = find<OniStatus (*)(const char*)>("oniDriverTryDevice");
    open_ = find<DeviceBase* (*)(const char*, const char*)>("oniDriverDeviceOpen");
    close_ = find<void (*)(DeviceBase*)>("oniDriverDeviceClose");
    enable_sync_ = find<void* (*)(StreamBase**, int)>("oniDriverEnableFrameSync");
    disable_sync_ = find<void (*)(void*)>("oniDriverDisableFrameSync");
    complete_ =
        create && begin && destroy_ && try_device_ && open_ && close_ && enable_sync_ && disable_sync_;
    if (!complete_) return ONI_STATUS_OK;
    create(services_);
    return begin(connected, disconnected, changed, cookie);
  }

  DeviceBase* deviceOpen(const char* uri, const char* mode) override {
    return complete_ ? open_(uri, mode) : nullptr;
  }
  void deviceClose(DeviceBase* device) override {
    if (complete_) close_(device);
  }
  OniStatus tryDevice(const char* uri) override { return complete_ ? try_device_(uri) : ONI_STATUS_ERROR; }
  void* enableFrameSync(StreamBase** streams, int count) override {
    return complete_ ? enable_sync_(streams, count) : nullptr;
  }
  void disableFrameSync(void* group) override {
    if (complete_) disable_sync_(group);
  }
  void shutdown() override {
    if (complete_) destroy_();
    complete_ = false;
  }

 private:
  template <class Function>
  Function find(const char* name) const {
    return reinterpret_cast<Function>(::dlsym(library_, name));
  }

  OniDriverServices* services_;
  void* library_ = nullptr;
  bool complete_ = false;
  void (*destroy_)() = nullptr;
  OniStatus (*try_device_)(const char*) = nullptr;
  DeviceBase* (*open_)(const char*, const char*) = nullptr;
  void (*close_)(DeviceBase*) = nullptr;
  void* (*enable_sync_)(StreamBase**, int) = nullptr;
  void (*disable_sync_)(void*) = nullptr;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::PrimeSenseDriver)
