#include "capture_server/sensor/open_ni.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "capture_server/drivers/contract/device_properties.h"
#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/cpu_starvation.h"

namespace copresence::sensor {

namespace {

// OpenNI2 unloads its drivers at the end, and its player of recordings forgets 9 kB each time it is loaded: it stays. Leak
// reports then also know what to call it.
void keep_player_loaded() {
  Dl_info open_ni;
  if (::dladdr(reinterpret_cast<void*>(&oniInitialize), &open_ni) == 0) return;
  const std::string path = open_ni.dli_fname;
  const std::string player = path.substr(0, path.find_last_of('/') + 1) + "OpenNI2/Drivers/libOniFile.so.0";
  // Without it OpenNI2 will say that it cannot play recordings.
  if (void* const loaded = ::dlopen(player.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) ::dlclose(loaded);
}

}  // namespace

openni::Status OpenNiSession::initialize(std::string_view choice) {
  keep_player_loaded();
  ::setenv(drivers::kChoiceVariable, std::string(choice).c_str(), 1);
  return openni::OpenNI::initialize();
}

void let_threads_leave() {
  using std::chrono::milliseconds;
  constexpr milliseconds kLeaves(50), kHardlyAnything(5);
  constexpr int kMostTimes = 8;
  for (int i = 0; i < kMostTimes; ++i) {
    const auto before = waited_for_a_core();
    std::this_thread::sleep_for(kLeaves);
    if (waited_for_a_core() - before < kHardlyAnything) return;
  }
}

std::string last_open_ni_error() {
  std::string text = openni::OpenNI::getExtendedError();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t' || c == '\r'; }, ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  text.erase(0, text.find_first_not_of(' '));
  return text.empty() ? "no reason given" : text;
}

std::vector<std::uint16_t> levels_of(const openni::VideoStream& depth) {
  // Some drivers want the size that their table has, which is 2048 entries everywhere seen; some write without asking for
  // the room. So there is always room for the largest that can be.
  constexpr std::size_t kUsual = 2048, kLargest = 65536;
  std::vector<std::uint16_t> levels(kLargest);
  for (const std::size_t entries : {kUsual, kLargest}) {
    int bytes = static_cast<int>(entries * sizeof(levels[0]));
    if (depth.getProperty(drivers::kDepthOfDisparity, levels.data(), &bytes) != openni::STATUS_OK) continue;
    levels.resize(std::clamp<std::size_t>(static_cast<std::size_t>(std::max(bytes, 0)) / sizeof(levels[0]), 0,
                                          kLargest));
    std::erase(levels, std::uint16_t{0});
    std::sort(levels.begin(), levels.end());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    return levels;
  }
  return {};
}

bool is_whole(const openni::VideoFrameRef& frame, const CameraModel& camera, int bytes_per_pixel) {
  const int row_bytes = camera.width * bytes_per_pixel;
  return frame.isValid() && frame.getData() && frame.getWidth() == camera.width &&
         frame.getHeight() == camera.height && frame.getStrideInBytes() >= row_bytes &&
         frame.getDataSize() == frame.getStrideInBytes() * camera.height;
}

void copy_depth(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into) {
  into.depth.resize(camera.width, camera.height);
  into.state.resize(camera.width, camera.height);
  const auto* row = static_cast<const std::uint8_t*>(frame.getData());
  for (int y = 0; y < camera.height; ++y, row += frame.getStrideInBytes()) {
    const auto depth = into.depth.row(y);
    const auto state = into.state.row(y);
    std::memcpy(depth.data(), row, depth.size_bytes());
    std::transform(depth.begin(), depth.end(), state.begin(),
                   [](std::uint16_t z) { return z ? DepthState::kMeasured : DepthState::kHole; });
  }
}

void copy_color(const openni::VideoFrameRef& frame, const CameraModel& camera, RgbdFrame& into) {
  ColorImage& color = into.color.emplace();
  color.resize(camera.width, camera.height);
  const auto* row = static_cast<const std::uint8_t*>(frame.getData());
  for (int y = 0; y < camera.height; ++y, row += frame.getStrideInBytes()) {
    const auto pixels = color.row(y);
    std::memcpy(pixels.data(), row, pixels.size_bytes());
  }
}

}  // namespace copresence::sensor
