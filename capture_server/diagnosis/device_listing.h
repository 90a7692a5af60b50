#pragma once

// Lists the cameras of this machine for capture_server --list: what OpenNI2 finds, and what the USB
// bus shows about why a camera does not work.
// Thread: list_devices() uses OpenNI2, see sensor/frame_source.h. add_bus_facts() is safe anywhere.

#include <string>
#include <vector>

#include "capture_server/diagnosis/usb_cameras.h"
#include "common/result.h"

namespace copresence::diagnosis {

struct DeviceListing {
  std::string source;  ///< The argument of --source. The text is empty if the camera cannot be opened.
  std::string name;    ///< Vendor and model.
  std::string serial;  ///< Serial number, or empty if the camera reports none.
  std::string driver;
  std::vector<std::string> modes;     ///< Modes such as "depth 640x480 at 30, 1 mm".
  std::vector<std::string> problems;  ///< Problems of the camera: one sentence each, with the remedy.
  bool ready = false;                 ///< True if the camera could be opened just now.
};

/// Lists every camera that OpenNI2 finds, and those that only the USB bus shows. Each camera is
/// opened for a moment to find out whether it can be used.
/// Fails with kUnavailable if OpenNI2 does not start.
Result<std::vector<DeviceListing>> list_devices(const UsbPaths& paths = {});

/// Adds the problems that the bus shows to the listed cameras, and lists cameras with a problem
/// that no driver has found. A camera is matched by its serial number, its bus address, or as the
/// only unmatched camera of its kind. So a working camera is listed once.
void add_bus_facts(std::vector<DeviceListing>& listing, const std::vector<UsbCamera>& bus);

}  // namespace copresence::diagnosis
