// The driver of PrimeSense and Asus Xtion cameras, by Debian's PS1080 driver. PS1080 is loaded only
// if it is chosen, since its shutdown takes up to 0.4 s.

#include <optional>

#include "capture_server/drivers/contract/foreign_driver.h"
#include "capture_server/drivers/contract/open_ni_driver.h"

namespace copresence::drivers {
namespace {

using oni::driver::DeviceBase;
using oni::driver::StreamBase;

constexpr const char* kPs1080 = COPRESENCE_OPENNI_DRIVERS "/libPS1080.so.0";

class PrimeSenseDriver final : public ForeignDriverHost {
 public:
  explicit PrimeSenseDriver(OniDriverServices* services) : ForeignDriverHost(services, kPrimeSense) {}

  OniStatus load(oni::driver::DeviceConnectedCallback connected,
                 oni::driver::DeviceDisconnectedCallback disconnected,
                 oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    ps1080_ = ForeignDriver::load(kPs1080);
    if (!ps1080_) return ONI_STATUS_OK;  // Other drivers may have cameras.
    ps1080_->create(services());
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
  std::optional<ForeignDriver> ps1080_;
};

}  // namespace
}  // namespace copresence::drivers

ONI_EXPORT_DRIVER(copresence::drivers::PrimeSenseDriver)
