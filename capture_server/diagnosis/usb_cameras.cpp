#include "capture_server/diagnosis/usb_cameras.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

namespace copresence::diagnosis {
namespace {

namespace fs = std::filesystem;

struct Known {
  std::string_view vendor, product, model, kind;
};
constexpr Known kCameras[] = {
    {"045e", "02ae", "Kinect", "kinect_v1"},      {"045e", "02bf", "Kinect for Windows", "kinect_v1"},
    {"1d27", "0500", "PrimeSense", "primesense"}, {"1d27", "0600", "Asus Xtion", "primesense"},
    {"1d27", "0601", "Asus Xtion", "primesense"}, {"1d27", "0609", "PrimeSense", "primesense"},
};
constexpr std::string_view kMicrosoft = "045e", kMotor = "02b0";
constexpr std::string_view kKinectAudio[] = {"02ad", "02bb", "02be", "02c3"};

// A USB device, as /sys describes it.
struct Device {
  std::string vendor, product, serial, speed;
  // Name of the device's folder: 1-4.2 is plugged into port 2 of device 1-4.
  std::string name;
  int bus = 0, address = 0;
};

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

int number(const std::string& text) {
  int value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::vector<Device> read_bus(const std::string& folder) {
  std::vector<Device> devices;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const fs::path& path = entry.path();
    Device device{first_line(path / "idVendor"),      first_line(path / "idProduct"),
                  first_line(path / "serial"),        first_line(path / "speed"),
                  path.filename().string(),           number(first_line(path / "busnum")),
                  number(first_line(path / "devnum"))};
    if (!device.vendor.empty()) devices.push_back(std::move(device));
  }
  std::sort(devices.begin(), devices.end(), [](const Device& a, const Device& b) { return a.name < b.name; });
  return devices;
}

const Known* known(const Device& device) {
  const auto* found = std::find_if(std::begin(kCameras), std::end(kCameras), [&](const Known& camera) {
    return camera.vendor == device.vendor && camera.product == device.product;
  });
  return found == std::end(kCameras) ? nullptr : found;
}

// The process that has the node open, as "name (process 123)". Only root sees other users'
// processes.
std::optional<std::string> holder(const std::string& node, const std::string& processes) {
  std::error_code none;
  const std::string own = std::to_string(::getpid());
  for (const auto& process : fs::directory_iterator(processes, none)) {
    const std::string id = process.path().filename().string();
    if (number(id) == 0 || id == own) continue;
    for (const auto& file : fs::directory_iterator(process.path() / "fd", none)) {
      if (fs::read_symlink(file.path(), none) != node) continue;
      return fmt::format("{} (process {})", first_line(process.path() / "comm"), id);
    }
  }
  return std::nullopt;
}

// Name of the hub that a device is plugged into: 1-4.1 and 1-4.3 share 1-4.
std::string hub_of(const std::string& name) {
  return name.substr(0, name.find_last_of('.'));
}

bool is_blank(const std::string& serial) {
  return serial.find_first_not_of('0') == std::string::npos;
}

// The camera of a Kinect 1473 or Kinect for Windows has zeros as its serial number. So libfreenect
// reports the serial number of the audio device on the same hub.
std::string serial_of(const Device& device, const std::vector<Device>& devices) {
  if (device.vendor != kMicrosoft || !is_blank(device.serial)) return device.serial;
  const auto audio = std::find_if(devices.begin(), devices.end(), [&](const Device& other) {
    const bool is_audio =
        other.vendor == kMicrosoft &&
        std::find(std::begin(kKinectAudio), std::end(kKinectAudio), other.product) != std::end(kKinectAudio);
    return is_audio && !is_blank(other.serial) && hub_of(other.name) == hub_of(device.name);
  });
  return audio == devices.end() ? device.serial : audio->serial;
}

}  // namespace

std::vector<UsbCamera> find_usb_cameras(const UsbPaths& paths) {
  std::vector<UsbCamera> cameras;
  const std::vector<Device> devices = read_bus(paths.devices);
  for (const Device& device : devices) {
    const Known* model = known(device);
    if (!model) continue;
    UsbCamera camera{std::string(model->model),
                     serial_of(device, devices),
                     fmt::format("{}/{:03}/{:03}", paths.nodes, device.bus, device.address),
                     std::string(model->kind),
                     fmt::format("@{}/{}", device.bus, device.address),
                     {},
                     false};
    if (::access(camera.node.c_str(), R_OK | W_OK) != 0) {
      camera.blocked = true;
      camera.problems.push_back(fmt::format(
          "you may not open {}: copy packaging/udev/70-copresence-cameras.rules to /etc/udev/rules.d, run "
          "\"udevadm control --reload\" as root and plug the camera in again",
          camera.node));
    } else if (const auto who = holder(camera.node, paths.processes)) {
      camera.blocked = true;
      camera.problems.push_back(fmt::format("{} has it open: end that program", *who));
    }
    const auto neighbours = std::count_if(devices.begin(), devices.end(), [&](const Device& other) {
      return known(other) && other.bus == device.bus;
    });
    if (neighbours > 1) {
      camera.problems.push_back(fmt::format(
          "{} depth cameras share USB bus {}, which has room for one: plug each into a controller of its own",
          neighbours, device.bus));
    }
    if (!device.speed.empty() && number(device.speed) < 480) {
      camera.problems.push_back(fmt::format(
          "it runs at {} Mbit/s, too slow for pictures: use a USB 2 port and another cable", device.speed));
    }
    cameras.push_back(std::move(camera));
  }
  for (const Device& device : devices) {
    if (device.vendor != kMicrosoft || device.product != kMotor) continue;
    const bool has_camera = std::any_of(devices.begin(), devices.end(), [&](const Device& other) {
      return known(other) && hub_of(other.name) == hub_of(device.name);
    });
    if (has_camera) continue;
    cameras.push_back({"Kinect",
                       {},
                       fmt::format("{}/{:03}/{:03}", paths.nodes, device.bus, device.address),
                       "kinect_v1",
                       {},
                       {"only its motor shows: plug in its power supply"},
                       true});
  }
  return cameras;
}

}  // namespace copresence::diagnosis
