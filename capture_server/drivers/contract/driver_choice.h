#pragma once

// The choice of camera drivers that are active in a process. OpenNI2 loads every driver in its
// folder, and the shutdown of PS1080 alone takes up to 0.4 s. So the drivers of this project do
// nothing unless they are chosen.
//
// An environment variable passes the choice, because a driver is a separate library and shares
// nothing else with its process. The variable is set before OpenNI2 is initialised. If the variable
// is not set, all drivers are active, so that other programs (NiViewer2) find every camera.
//

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace copresence::drivers {

inline constexpr const char* kChoiceVariable = "COPRESENCE_DRIVERS";
inline constexpr std::string_view kPrimeSense = "primesense", kKinectV1 = "kinect_v1",
                                  kSimulated = "simulated",
                                  kInstalled = "installed";  ///< Drivers that a user has installed.
/// Lists of drivers: their names, joined by commas.
inline constexpr std::string_view kOtherThanKinects = "primesense,installed",
                                  kRealCameras = "primesense,kinect_v1,installed",
                                  kEveryDriver = "primesense,kinect_v1,installed,simulated";

/// The driver of an OpenNI2 URI. Most third-party URIs are VENDOR/PRODUCT@BUS/ADDRESS.
inline std::string_view driver_of(std::string_view uri) {
  if (uri.starts_with("simulated:")) return kSimulated;
  if (uri.starts_with("freenect:")) return kKinectV1;
  return uri.starts_with("1d27/") ? kPrimeSense : kInstalled;
}

/// True if the driver with this name is active in this process.
inline bool is_chosen(std::string_view driver) {
  const char* const variable = std::getenv(kChoiceVariable);
  if (!variable) return true;
  for (std::string_view rest = variable; !rest.empty();) {
    const auto comma = std::min(rest.find(','), rest.size());
    if (rest.substr(0, comma) == driver) return true;
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return false;
}

}  // namespace copresence::drivers
