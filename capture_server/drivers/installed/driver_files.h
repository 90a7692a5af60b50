#pragma once

// Which drivers for OpenNI2 a user has installed beside those that this project brings.
//
// Thread: free functions, safe anywhere.

#include <string>
#include <vector>

namespace copresence::drivers {

/// Folders in which OpenNI2 or a vendor's installer puts drivers, the first ones first: OPENNI2_DRIVERS_PATH
/// (a folder of drivers), OPENNI2_REDIST (a folder that holds OpenNI2/Drivers), then `system_folder`
/// (Debian's) and the usual ones of /usr and /usr/local.
std::vector<std::string> driver_folders(const std::string& system_folder);

/// Paths of the drivers in these folders, whole, each once, sorted within a folder; of two with one name the
/// first folder's. Left out are drivers of cameras that our own drivers serve (PS1080, FreenectDriver), the
/// player of recordings (OniFile), OpenNI2's example (DummyDevice), and this project's.
std::vector<std::string> installed_drivers(const std::vector<std::string>& folders);

}  // namespace copresence::drivers
