#include "capture_server/sensor/source.h"

#include <string_view>

#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/sensor/device_source.h"
#include "capture_server/sensor/recording_source.h"

namespace copresence::sensor {
namespace {

constexpr std::string_view kDevicePrefix = "openni:";

}  // namespace

bool is_recording(const std::string& source) {
  return !source.starts_with(kDevicePrefix) && !source.starts_with(drivers::kSimulatedPrefix);
}

Result<std::unique_ptr<FrameSource>> open_source(const std::string& source, const SourceSettings& settings) {
  if (is_recording(source)) return open_recording(source, settings);
  if (source.starts_with(kDevicePrefix))
    return open_reconnecting_device(source.substr(kDevicePrefix.size()), settings.controls);
  if (const auto uri = drivers::parse_simulated_uri(source); !uri) return fail(uri.error());
  return open_reconnecting_device(source, settings.controls);
}

}  // namespace copresence::sensor
