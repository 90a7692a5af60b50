#pragma once

// The cameras of this machine, for capture_server --list: what OpenNI2 finds, and what the USB bus
// knows about why a camera does not work.
//
// Thread: free functions. list_devices() uses OpenNI2: see sensor/frame_source.h.

#include <string>
#include <vector>

#include "capture_server/diagnosis/usb_cameras.h"
#include "common/result.h"

namespace copresence::diagnosis {

struct DeviceListing {
  std::string source;  ///< the argument of --source; empty if the camera cannot be opened at all
  std::string name;    ///< vendor and model
  std::string serial;  ///< empty if it reports none
  std::string driver;
  std::vector<std::string> modes;     ///< "depth 640x480 at 30, 1 mm"
  std::vector<std::string> problems;  ///< one sentence each, with its remedy
  bool ready = false;                 ///< whether it could be opened just now
};

/// Every camera that OpenNI2 finds, each opened for a moment to see whether it can be, and those
/// that only the USB bus shows.
/// Fails  kUnavailable (OpenNI2 does not start).
Result<std::vector<DeviceListing>> list_devices(const UsbPaths& paths = {});

/// Adds to each listed camera the problems that the bus shows, and lists cameras with a problem
/// that no driver has found. A camera is matched by its serial number, else by its bus address,
/// else as the only unmatched one of its kind on either side. So a working camera is listed once.
void add_bus_facts(std::vector<DeviceListing>& listing, const std::vector<UsbCamera>& bus);

}  // namespace copresence::diagnosis
