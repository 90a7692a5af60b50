#pragma once

// Depth cameras as the USB bus has them, whether or not anybody may open them, and what keeps them from
// working. Read from /sys, /dev and /proc: no camera is touched.
//
// Thread: free functions, safe anywhere.

#include <string>
#include <vector>

namespace copresence::sensor {

struct UsbCamera {
  std::string model;  ///< "Kinect", "Asus Xtion"
  std::string
      serial;  ///< as drivers report it; empty or zeros where neither the camera nor its audio device has one
  std::string node;   ///< /dev/bus/usb/BBB/DDD
  std::string kind;   ///< as drivers are called: kinect_v1, primesense
  std::string place;  ///< "@BUS/ADDRESS", the end of what PrimeSense's driver calls it
  std::vector<std::string>
      problems;          ///< one sentence each, with its mend; empty where nothing is known to be wrong
  bool blocked = false;  ///< whether they keep it from opening, for this user, now
};

/// Where the system tells about itself; other places are for tests.
struct UsbPlaces {
  std::string devices = "/sys/bus/usb/devices";
  std::string nodes = "/dev/bus/usb";
  std::string processes = "/proc";
};

/// Every depth camera that is plugged in, and Kinects without power, of which only the motor shows.
std::vector<UsbCamera> find_usb_cameras(const UsbPlaces& places = {});

}  // namespace copresence::sensor
