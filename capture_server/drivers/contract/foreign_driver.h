#pragma once

// Embeds a third-party camera driver in a driver of this project. The other driver's library is
// loaded from its installed path, and only if it is needed. Devices and streams are passed on
// unchanged, because they have the same virtual functions in every OpenNI2 driver.
// Thread: OpenNI2 calls a driver from the threads of its users.

#include <optional>
#include <string>
#include <string_view>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/drivers/contract/open_ni_driver.h"

namespace copresence::drivers {

class ForeignDriver {
 public:
  /// Loads the library. The library stays loaded until the process ends, since threads of PS1080
  /// were seen to run in it after its shutdown. Returns nothing if the file is not an OpenNI2
  /// driver.
  static std::optional<ForeignDriver> load(const std::string& path);

  /// The following functions call the functions that the library exports.
  void create(OniDriverServices* services) const { create_(services); }
  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) const {
    return initialize_(connected, disconnected, changed, cookie);
  }
  OniStatus try_device(const char* uri) const { return try_device_(uri); }
  oni::driver::DeviceBase* open(const char* uri, const char* mode) const { return open_(uri, mode); }
  void close(oni::driver::DeviceBase* device) const { close_(device); }
  void* enable_sync(oni::driver::StreamBase** streams, int count) const {
    return enable_sync_(streams, count);
  }
  void disable_sync(void* group) const { disable_sync_(group); }
  void destroy() const { destroy_(); }

 private:
  ForeignDriver() = default;

  void (*create_)(OniDriverServices*) = nullptr;
  OniStatus (*initialize_)(oni::driver::DeviceConnectedCallback, oni::driver::DeviceDisconnectedCallback,
                           oni::driver::DeviceStateChangedCallback, void*) = nullptr;
  OniStatus (*try_device_)(const char*) = nullptr;
  oni::driver::DeviceBase* (*open_)(const char*, const char*) = nullptr;
  void (*close_)(oni::driver::DeviceBase*) = nullptr;
  void* (*enable_sync_)(oni::driver::StreamBase**, int) = nullptr;
  void (*disable_sync_)(void*) = nullptr;
  void (*destroy_)() = nullptr;
};

/// Base of a driver that forwards OpenNI2's calls to third-party drivers.
class ForeignDriverHost : public oni::driver::DriverBase {
 public:
  /// `name` is one of the names in driver_choice.h.
  ForeignDriverHost(OniDriverServices* services, std::string_view name)
      : DriverBase(services), services_(services), name_(name) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) final {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    return is_chosen(name_) ? load(connected, disconnected, changed, cookie) : ONI_STATUS_OK;
  }

 protected:
  /// OpenNI2 calls this function once, if the driver is chosen.
  virtual OniStatus load(oni::driver::DeviceConnectedCallback connected,
                         oni::driver::DeviceDisconnectedCallback disconnected,
                         oni::driver::DeviceStateChangedCallback changed, void* cookie) = 0;

  OniDriverServices* services() const { return services_; }

 private:
  OniDriverServices* services_;
  std::string_view name_;
};

}  // namespace copresence::drivers
