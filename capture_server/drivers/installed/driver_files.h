#pragma once

// Finds the OpenNI2 drivers that a user has installed in addition to this project's.
// Thread: free functions, safe anywhere.

#include <string>
#include <vector>

namespace copresence::drivers {

/// Folders in which OpenNI2 or a vendor's installer puts drivers, in order of precedence:
/// OPENNI2_DRIVERS_PATH, OpenNI2/Drivers in OPENNI2_REDIST, `system_folder` (Debian's), and the
/// usual folders in /usr and /usr/local.
std::vector<std::string> driver_folders(const std::string& system_folder);

/// Full paths of the drivers in these folders, sorted within each folder. Of two drivers with the
/// same name, the one in the first folder is used. The list leaves out this project's drivers and
/// drivers for the same cameras (PS1080, FreenectDriver). It also leaves out OpenNI2's player
/// (OniFile) and its example (DummyDevice).
std::vector<std::string> installed_drivers(const std::vector<std::string>& folders);

}  // namespace copresence::drivers
