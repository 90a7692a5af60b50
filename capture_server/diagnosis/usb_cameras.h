#pragma once

// Finds depth cameras on the USB bus, even if this user may not open them, and the reasons why they
// do not work. The search reads /sys, /dev and /proc and opens no camera.
// Thread: free functions, safe anywhere.

#include <string>
#include <vector>

namespace copresence::diagnosis {

struct UsbCamera {
  std::string model;  ///< Name of the model, such as "Kinect" or "Asus Xtion".
  /// Serial number as drivers report it. Empty or zeros if the camera and its audio device have no
  /// number.
  std::string serial;
  std::string node;                   ///< Device file, /dev/bus/usb/BBB/DDD.
  std::string kind;                   ///< Name of the driver: kinect_v1 or primesense.
  std::string address;                ///< End of the URI in PrimeSense's driver, "@BUS/ADDRESS".
  std::vector<std::string> problems;  ///< Problems of the camera: one sentence each, with the remedy.
  bool blocked = false;               ///< True if this user cannot open the camera because of these problems.
};

/// Folders in which the system lists USB devices and processes. Tests use other folders.
struct UsbPaths {
  std::string devices = "/sys/bus/usb/devices";
  std::string nodes = "/dev/bus/usb";
  std::string processes = "/proc";
};

/// Finds every depth camera that is plugged in. Includes Kinects without power, seen by their
/// motor.
std::vector<UsbCamera> find_usb_cameras(const UsbPaths& paths = {});

}  // namespace copresence::diagnosis
