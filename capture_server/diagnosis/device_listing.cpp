#include "capture_server/diagnosis/device_listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/open_ni.h"

namespace copresence::diagnosis {
namespace {

std::string_view name_of(openni::PixelFormat format) {
  switch (format) {
    case openni::PIXEL_FORMAT_DEPTH_1_MM:
      return "1 mm";
    case openni::PIXEL_FORMAT_DEPTH_100_UM:
      return "0.1 mm";
    case openni::PIXEL_FORMAT_RGB888:
      return "RGB";
    case openni::PIXEL_FORMAT_GRAY8:
      return "8 bits";
    case openni::PIXEL_FORMAT_GRAY16:
      return "16 bits";
    default:
      return "";  // Packed and shifted formats are not used.
  }
}

void add_modes(openni::Device& device, openni::SensorType type, std::string_view name,
               std::vector<std::string>& into) {
  const openni::SensorInfo* sensor = device.getSensorInfo(type);
  if (!sensor) return;
  const auto& modes = sensor->getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    const openni::VideoMode& mode = modes[i];
    const std::string_view format = name_of(mode.getPixelFormat());
    if (format.empty()) continue;
    into.push_back(fmt::format("{} {}x{} at {}, {}", name, mode.getResolutionX(), mode.getResolutionY(),
                               mode.getFps(), format));
  }
}

DeviceListing look_at(const openni::DeviceInfo& found) {
  const std::string uri = found.getUri();
  DeviceListing entry;
  entry.driver = drivers::driver_of(uri);
  entry.source = entry.driver == drivers::kSimulated ? uri : "openni:" + uri;
  entry.name = fmt::format("{} {}", found.getVendor(), found.getName());
  openni::Device device;
  if (device.open(uri.c_str()) != openni::STATUS_OK) {
    // The USB bus may give a more precise reason, which then replaces this one.
    entry.problems.push_back(fmt::format(
        "it does not open ({}): end other programs that use it (another user's show only to root), or "
        "unplug it and plug it in again",
        sensor::last_open_ni_error()));
    return entry;
  }
  char serial[ONI_MAX_STR] = {};
  int size = sizeof(serial) - 1;
  if (device.getProperty(ONI_DEVICE_PROPERTY_SERIAL_NUMBER, serial, &size) == openni::STATUS_OK)
    entry.serial = serial;
  add_modes(device, openni::SENSOR_DEPTH, "depth", entry.modes);
  add_modes(device, openni::SENSOR_COLOR, "colour", entry.modes);
  add_modes(device, openni::SENSOR_IR, "infrared", entry.modes);
  entry.ready = device.hasSensor(openni::SENSOR_DEPTH);
  if (!entry.ready) entry.problems.emplace_back("it has no depth sensor: use a depth camera");
  device.close();
  return entry;
}

}  // namespace

void add_bus_facts(std::vector<DeviceListing>& listing, const std::vector<UsbCamera>& bus) {
  std::vector<DeviceListing*> entry_of(bus.size(), nullptr);
  const auto is_free = [&](const DeviceListing& entry) {
    return std::find(entry_of.begin(), entry_of.end(), &entry) == entry_of.end();
  };
  const auto match = [&](const auto& same) {
    for (std::size_t i = 0; i < bus.size(); ++i) {
      if (entry_of[i]) continue;
      const auto found = std::find_if(listing.begin(), listing.end(), [&](const DeviceListing& entry) {
        return entry.driver == bus[i].kind && is_free(entry) && same(entry, bus[i]);
      });
      if (found != listing.end()) entry_of[i] = &*found;
    }
  };
  match([](const DeviceListing& entry, const UsbCamera& camera) {
    return !camera.serial.empty() && entry.source.ends_with("//" + camera.serial);
  });
  match([](const DeviceListing& entry, const UsbCamera& camera) {
    return !camera.address.empty() && entry.source.ends_with(camera.address);
  });
  // If one camera of a kind is unmatched on each side, the two are the same camera.
  const auto left_of = [&](const std::string& kind) {
    std::size_t cameras = 0;
    for (std::size_t i = 0; i < bus.size(); ++i)
      cameras += !entry_of[i] && bus[i].kind == kind && !bus[i].address.empty();
    const auto entries = std::count_if(listing.begin(), listing.end(), [&](const DeviceListing& entry) {
      return entry.driver == kind && is_free(entry);
    });
    return cameras == 1 && entries == 1;
  };
  match([&](const DeviceListing& entry, const UsbCamera& camera) {
    return !camera.address.empty() && left_of(entry.driver);
  });

  std::vector<DeviceListing> only_on_bus;
  for (std::size_t i = 0; i < bus.size(); ++i) {
    const UsbCamera& camera = bus[i];
    DeviceListing* entry = entry_of[i];
    if (!entry && camera.problems.empty()) continue;  // The camera is already listed.
    if (!entry)
      entry = &only_on_bus.emplace_back(
          DeviceListing{{}, camera.model, camera.serial, camera.kind, {}, {}, false});
    if (camera.blocked) entry->problems.clear();  // The bus gives the more precise reason.
    entry->problems.insert(entry->problems.end(), camera.problems.begin(), camera.problems.end());
  }
  listing.insert(listing.end(), only_on_bus.begin(), only_on_bus.end());
}

Result<std::vector<DeviceListing>> list_devices(const UsbPaths& paths) {
  // Read the bus before this process opens any camera.
  const std::vector<UsbCamera> bus = find_usb_cameras(paths);
  const sensor::OpenNiSession session(drivers::kEveryDriver);
  if (!session.is_up()) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("OpenNI2 does not start: {}; install the package libopenni2-0 again",
                            sensor::last_open_ni_error()));
  }
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  std::vector<DeviceListing> listing;
  listing.reserve(static_cast<std::size_t>(devices.getSize()) + bus.size());
  for (int i = 0; i < devices.getSize(); ++i) listing.push_back(look_at(devices[i]));
  add_bus_facts(listing, bus);
  return listing;
}

}  // namespace copresence::diagnosis
