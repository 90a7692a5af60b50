#pragma once

// A camera driver of somebody else, a library of its own, inside a driver of ours: loaded from where it is
// installed, and only where it is wanted. Devices and streams are its own objects; OpenNI2's driver interface
// gives them the same virtual functions wherever they come from.
//
// Thread: as OpenNI2 calls a driver.

#include <optional>
#include <string>

#include "capture_server/drivers/contract/open_ni_driver.h"

namespace copresence::drivers {

class ForeignDriver {
 public:
  /// Loads the library; it stays loaded to the end of the process, since threads of PS1080 have been seen in
  /// it after it said that it was done. Nothing where the file is not there or is no driver for OpenNI2.
  static std::optional<ForeignDriver> load(const std::string& path);

  /// As the functions that a driver's library exports.
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

}  // namespace copresence::drivers
