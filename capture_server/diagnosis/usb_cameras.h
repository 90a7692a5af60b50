#pragma once

// Depth cameras on the USB bus, whether or not this user may open them, and what keeps them from
// working. Read from /sys, /dev and /proc: no camera is opened.
//
// Thread: free functions, safe anywhere.

#include <string>
#include <vector>

namespace copresence::diagnosis {

struct UsbCamera {
  std::string model;  ///< "Kinect", "Asus Xtion"
  std::string
      serial;  ///< as drivers report it; empty or zeros if neither the camera nor its audio device has one
  std::string node;                   ///< /dev/bus/usb/BBB/DDD
  std::string kind;                   ///< name of the driver: kinect_v1, primesense
  std::string address;                ///< "@BUS/ADDRESS", the end of the URI in PrimeSense's driver
  std::vector<std::string> problems;  ///< one sentence each, with its remedy; empty if none is known
  bool blocked = false;               ///< whether this user cannot open it because of them
};

/// Where the system describes itself; tests use other folders.
struct UsbPaths {
  std::string devices = "/sys/bus/usb/devices";
  std::string nodes = "/dev/bus/usb";
  std::string processes = "/proc";
};

/// Every depth camera that is plugged in, and Kinects without power, of which only the motor is
/// visible.
std::vector<UsbCamera> find_usb_cameras(const UsbPaths& paths = {});

}  // namespace copresence::diagnosis
