// PrimeSense and Asus Xtion cameras by Debian's own PS1080 driver, which is loaded only where it is chosen: it takes
// up to 0.4 s to leave.

#include <optional>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/foreign_driver.h"
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
    ps1080_ = ForeignDriver::load(kPs1080);
    if (!ps1080_) return ONI_STATUS_OK;  // a machine without it has no such camera, and may have others
    ps1080_->create(services_);
    return ps1080_->initialize(connected, disconnected, changed, cookie);
  }

  DeviceBase* deviceOpen(const char* uri, const char* mode) override {
    return ps1080_ ? ps1080_->open(uri, mode) : nullptr;
  }
  void deviceClose(DeviceBase* device) override {
    if (ps1080_) ps1080_->close(device);
  }
  OniStatus tryDevice(const char* uri) override {
    return ps1080_ ? ps1080_->try_device(uri) : ONI_STATUS_ERROR;
  }
  void* enableFrameSync(StreamBase** streams, int count) override {
    return ps1080_ ? ps1080_->enable_sync(streams, count) : nullptr;
  }
  void disableFrameSync(void* group) override {
    if (ps1080_) ps1080_->disable_sync(group);
  }
  void shutdown() override {
    if (ps1080_) ps1080_->destroy();
    ps1080_.reset();
  }

 private:
  OniDriverServices* services_;
  std::optional<ForeignDriver> ps1080_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::PrimeSenseDriver)
