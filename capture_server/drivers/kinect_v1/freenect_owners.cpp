#include "capture_server/drivers/kinect_v1/freenect_owners.h"

#include <algorithm>

namespace copresence::drivers {
namespace {

thread_local std::string newest_error;

void keep_error(freenect_context*, freenect_loglevel level, const char* message) {
  if (level <= FREENECT_LOG_ERROR) newest_error = message;
}

}  // namespace

FreenectContext make_freenect_context(int parts) {
  freenect_context* made = nullptr;
  if (freenect_init(&made, nullptr) < 0 || !made) return nullptr;
  FreenectContext context(made);
  freenect_set_log_level(made, FREENECT_LOG_ERROR);
  freenect_set_log_callback(made, keep_error);
  freenect_select_subdevices(made, static_cast<freenect_device_flags>(parts));
  return context;
}

std::string last_freenect_error() {
  std::string text = newest_error;
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text.empty() ? "no reason given" : text;
}

std::optional<std::vector<std::string>> list_serials(freenect_context& context) {
  freenect_device_attributes* first = nullptr;
  if (freenect_list_device_attributes(&context, &first) < 0) return std::nullopt;
  std::vector<std::string> serials;
  for (const auto* device = first; device; device = device->next) {
    if (device->camera_serial && *device->camera_serial) serials.emplace_back(device->camera_serial);
  }
  freenect_free_device_attributes(first);
  return serials;
}

}  // namespace copresence::drivers
