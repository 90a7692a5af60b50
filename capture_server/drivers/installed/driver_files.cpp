#include "capture_server/drivers/installed/driver_files.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string_view>

namespace copresence::drivers {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kServedOtherwise[] = {"PS1080", "FreenectDriver", "OniFile", "DummyDevice"};

// The part of a library's name between "lib" and ".so". Empty for other names.
std::string_view stem_of(std::string_view file) {
  const auto end = file.find(".so");
  const bool is_library = file.starts_with("lib") && end != std::string_view::npos &&
                          (end + 3 == file.size() || file[end + 3] == '.');
  return is_library ? file.substr(3, end - 3) : std::string_view();
}

bool is_wanted(std::string_view stem) {
  return !stem.empty() && !stem.starts_with("Copresence") &&
         std::find(std::begin(kServedOtherwise), std::end(kServedOtherwise), stem) ==
             std::end(kServedOtherwise);
}

}  // namespace

std::vector<std::string> driver_folders(const std::string& system_folder) {
  std::vector<std::string> folders;
  if (const char* drivers = std::getenv("OPENNI2_DRIVERS_PATH"); drivers && *drivers)
    folders.emplace_back(drivers);
  if (const char* redist = std::getenv("OPENNI2_REDIST"); redist && *redist)
    folders.push_back((fs::path(redist) / "OpenNI2/Drivers").string());
  folders.push_back(system_folder);
  for (const char* prefix : {"/usr/local/lib", "/usr/lib"})
    folders.push_back(prefix + std::string("/OpenNI2/Drivers"));
  return folders;
}

std::vector<std::string> installed_drivers(const std::vector<std::string>& folders) {
  std::vector<std::string> found;
  std::set<std::string, std::less<>> names;
  for (const std::string& folder : folders) {
    std::set<fs::path> files;  // The set sorts libX.so before libX.so.0.
    std::error_code none;
    fs::directory_iterator entries(folder, none);
    for (; !none && entries != fs::directory_iterator(); entries.increment(none))
      files.insert(entries->path());
    for (const fs::path& file : files) {
      const std::string name = file.filename();
      const std::string_view stem = stem_of(name);
      if (!is_wanted(stem) || !names.emplace(stem).second) continue;
      const fs::path real = fs::canonical(file, none);
      // A symbolic link may have another name than its target.
      if (none || !is_wanted(stem_of(real.filename().string()))) continue;
      if (std::find(found.begin(), found.end(), real.string()) == found.end()) found.push_back(real);
    }
  }
  return found;
}

}  // namespace copresence::drivers
