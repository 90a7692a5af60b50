// A fake libfreenect without USB for tests. It has the functions that the Kinect driver calls, with
// the same names and behaviour. Its Kinects are files. It is built as libfreenect.so.0.5, and
// LD_LIBRARY_PATH puts it before the real one.
//
// COPRESENCE_FAKE_KINECTS names a folder. Each file in the folder is a Kinect that is plugged in,
// and the file's name is its serial number. Removing the file unplugs the Kinect. Words in the file
// make the Kinect fail as long as they are there:
//
//   stall            It sends no pictures and reports no error.
//   slow_start       The first picture comes after two seconds.
//   transfer_error   Processing of events fails.
//   short_frame      Packets are lost, so the lower half of each picture is empty.
//   busy             It cannot be opened.
//   no_motor         It can be opened only without its motor.
//   windows          It is a Kinect for Windows, which has a near mode.
//   crash            The process crashes inside the library.
//   still            All pictures of a stream equal its first one, so that benchmarks exclude
//                    drawing.
//   slow_open=S      Opening takes S seconds.
//   blocked          Control transfers do not return: opening, starting, stopping and settings
//                    block.
//   1473             It is a model 1473. Its camera has no serial number, so libfreenect uses that
//                    of the audio device: AUDIO and the file's name.
//
// The Kinect's clock wraps half a second after the Kinect starts.

#include <libfreenect.h>
#include <libfreenect_registration.h>
#include <sys/time.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/support/fake_freenect/fake_scene.h"

using std::chrono::microseconds;
using std::chrono::steady_clock;
namespace fake = copresence::fake_freenect;

struct _freenect_context {
  freenect_log_cb log = nullptr;
  int parts = FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR;
  std::vector<freenect_device*> devices;
};

namespace {

struct Stream {
  bool running = false;
  steady_clock::time_point begin;
  std::uint64_t next = 0;  // Number of the next frame.
  microseconds offset{0};  // Colour is exposed later than depth.
  std::vector<std::uint8_t> picture;

  steady_clock::time_point due() const {
    return begin + offset + microseconds(static_cast<std::int64_t>(next) * 1'000'000 / 30);
  }
};

}  // namespace

struct _freenect_device {
  freenect_context* context = nullptr;
  std::string serial;
  void* user = nullptr;
  freenect_depth_cb on_depth = nullptr;
  freenect_video_cb on_video = nullptr;
  freenect_depth_format depth_format = FREENECT_DEPTH_11BIT;
  freenect_video_format video_format = FREENECT_VIDEO_RGB;
  Stream depth, video;
  steady_clock::time_point powered = steady_clock::now();
  bool dead = false;
  bool has_motor = true;
  freenect_raw_tilt_state tilt{};
  // The file's content is cached for a moment, because reading the file at every call would
  // dominate the measured time.
  steady_clock::time_point looked{};
  bool there = true;
  std::vector<std::string> words;
};

namespace {

constexpr std::chrono::milliseconds kLookEvery(20);

std::filesystem::path bus() {
  const char* folder = std::getenv("COPRESENCE_FAKE_KINECTS");
  return folder ? folder : "/nonexistent";
}

std::vector<std::string> serials() {
  std::vector<std::string> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(bus(), none))
    found.push_back(entry.path().filename());
  std::sort(found.begin(), found.end());
  return found;
}

constexpr std::string_view kAudio = "AUDIO";

bool says(const std::string& serial, const char* word);

// Returns the serial number by which libfreenect names the Kinect of a file.
std::string announced(const std::string& file) {
  return says(file, "1473") ? std::string(kAudio) + file : file;
}

// Returns the file of a Kinect, or a name that no file has if there is no such Kinect.
std::string file_of(const std::string& serial) {
  if (!serial.starts_with(kAudio)) return says(serial, "1473") ? "" : serial;
  const std::string file = serial.substr(kAudio.size());
  return says(file, "1473") ? file : "";
}

bool is_there(const std::string& serial) {
  if (serial.empty()) return false;
  std::error_code none;
  return std::filesystem::exists(bus() / serial, none);
}

std::vector<std::string> words_of(const std::string& serial) {
  std::ifstream file(bus() / serial);
  std::vector<std::string> words;
  for (std::string word; file >> word;) words.push_back(word);
  return words;
}

bool says(const std::vector<std::string>& words, const char* word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}
bool says(const std::string& serial, const char* word) {
  return says(words_of(serial), word);
}

// Blocks like a control transfer of libfreenect, which has no time limit.
void transfer(const std::string& serial) {
  while (says(serial, "blocked")) std::this_thread::sleep_for(kLookEvery);
}

void take_time_to_open(const std::string& serial) {
  constexpr std::string_view kSlowOpen = "slow_open=";
  for (const std::string& word : words_of(serial)) {
    if (word.starts_with(kSlowOpen))
      std::this_thread::sleep_for(std::chrono::duration<double>(std::atof(word.c_str() + kSlowOpen.size())));
  }
}

int refuse(freenect_context* context, const char* why) {
  if (context->log) context->log(context, FREENECT_LOG_ERROR, why);
  return -1;
}

void draw_depth(freenect_device& device) {
  device.depth.picture.resize(2 * fake::kWidth * fake::kHeight);
  auto* pixels = reinterpret_cast<std::uint16_t*>(device.depth.picture.data());
  const bool registered = device.depth_format == FREENECT_DEPTH_REGISTERED;
  for (int y = 0; y < fake::kHeight; ++y) {
    for (int x = 0; x < fake::kWidth; ++x) *pixels++ = fake::depth_at(x, y, device.depth.next, registered);
  }
}

void draw_video(freenect_device& device) {
  const bool infrared = device.video_format == FREENECT_VIDEO_IR_8BIT;
  device.video.picture.assign(infrared ? fake::kWidth * 488 : 3 * fake::kWidth * fake::kHeight, 0);
  auto* bytes = device.video.picture.data();
  for (int y = 0; y < fake::kHeight; ++y) {
    for (int x = 0; x < fake::kWidth; ++x) {
      if (infrared) {
        *bytes++ = fake::infrared_at(x, y, device.video.next);
        continue;
      }
      const fake::Color color = fake::color_at(x, y, device.video.next);
      *bytes++ = color.r;
      *bytes++ = color.g;
      *bytes++ = color.b;
    }
  }
}

// The Kinect's 60 MHz clock. When the device is opened, the clock is half a second before it wraps.
std::uint32_t ticks_at(const freenect_device& device, steady_clock::time_point when) {
  const auto us = std::chrono::duration_cast<microseconds>(when - device.powered).count();
  return static_cast<std::uint32_t>(us * 60 - 30'000'000);
}

// Delivers the pictures that are due. Returns false if the device was unplugged.
bool work(freenect_device& device, steady_clock::time_point now) {
  if (now - device.looked >= kLookEvery) {
    device.looked = now;
    device.there = is_there(device.serial);
    device.words = words_of(device.serial);
  }
  if (device.dead || !device.there || says(device.words, "transfer_error")) {
    device.dead = true;
    return false;
  }
  if (says(device.words, "crash")) std::raise(SIGSEGV);
  const bool stalled = says(device.words, "stall");
  const bool loses_packets = says(device.words, "short_frame"), is_still = says(device.words, "still");
  for (Stream* stream : {&device.depth, &device.video}) {
    // On a busy machine, only the newest picture is delivered: drawing all pictures would never
    // catch up.
    constexpr std::uint64_t kMostLate = 5;
    const auto late =
        stream->running ? std::max<std::int64_t>((now - stream->due()) / microseconds(33'333), 0) : 0;
    if (static_cast<std::uint64_t>(late) > kMostLate) stream->next += static_cast<std::uint64_t>(late);
    while (stream->running && stream->due() <= now) {
      const bool is_depth = stream == &device.depth;
      if (!stalled) {
        if (!is_still || stream->picture.empty()) is_depth ? draw_depth(device) : draw_video(device);
        auto& picture = stream->picture;
        if (loses_packets)
          std::fill(picture.begin() + static_cast<std::ptrdiff_t>(picture.size() / 2), picture.end(), 0);
        const std::uint32_t ticks = ticks_at(device, stream->due());
        if (is_depth && device.on_depth) device.on_depth(&device, picture.data(), ticks);
        if (!is_depth && device.on_video) device.on_video(&device, picture.data(), ticks);
      }
      ++stream->next;
    }
  }
  return true;
}

int start(freenect_device* device, Stream& stream, microseconds offset) {
  transfer(device->serial);
  if (device->dead || stream.running) return -1;
  stream.begin = steady_clock::now();
  if (says(device->serial, "slow_start")) stream.begin += std::chrono::seconds(2);
  stream.next = 0;
  stream.picture.clear();
  stream.offset = offset;
  stream.running = true;
  return 0;
}

freenect_frame_mode mode_of(int bytes, int height, int fps) {
  freenect_frame_mode mode{};
  mode.resolution = FREENECT_RESOLUTION_MEDIUM;
  mode.bytes = bytes;
  mode.width = fake::kWidth;
  mode.height = static_cast<std::int16_t>(height);
  mode.framerate = static_cast<std::int8_t>(fps);
  mode.is_valid = 1;
  return mode;
}

}  // namespace

extern "C" {

int freenect_init(freenect_context** context, freenect_usb_context*) {
  *context = new freenect_context;
  return 0;
}

int freenect_shutdown(freenect_context* context) {
  while (!context->devices.empty()) freenect_close_device(context->devices.front());
  delete context;
  return 0;
}

void freenect_set_log_level(freenect_context*, freenect_loglevel) {}
void freenect_set_log_callback(freenect_context* context, freenect_log_cb log) {
  context->log = log;
}

int freenect_process_events_timeout(freenect_context* context, struct timeval* timeout) {
  const auto end = steady_clock::now() + microseconds(timeout->tv_sec * 1'000'000 + timeout->tv_usec);
  auto until = end;
  for (const freenect_device* device : context->devices) {
    for (const Stream* stream : {&device->depth, &device->video}) {
      if (stream->running) until = std::min(until, stream->due());
    }
  }
  std::this_thread::sleep_until(until);
  int result = 0;
  for (freenect_device* device : context->devices) {
    if (!work(*device, steady_clock::now())) result = -1;
  }
  return result;
}

int freenect_process_events(freenect_context* context) {
  timeval slice{0, 10'000};
  return freenect_process_events_timeout(context, &slice);
}

int freenect_num_devices(freenect_context*) {
  return static_cast<int>(serials().size());
}

int freenect_list_device_attributes(freenect_context*, freenect_device_attributes** list) {
  *list = nullptr;
  const auto all = serials();
  for (auto serial = all.rbegin(); serial != all.rend(); ++serial)
    *list = new freenect_device_attributes{*list, ::strdup(announced(*serial).c_str())};
  return static_cast<int>(all.size());
}

void freenect_free_device_attributes(freenect_device_attributes* list) {
  while (list) {
    freenect_device_attributes* next = list->next;
    std::free(const_cast<char*>(list->camera_serial));
    delete list;
    list = next;
  }
}

int freenect_supported_subdevices(void) {
  return FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR;
}
void freenect_select_subdevices(freenect_context* context, freenect_device_flags parts) {
  context->parts = parts;
}

int freenect_open_device_by_camera_serial(freenect_context* context, freenect_device** device,
                                          const char* announced_serial) {
  const std::string serial = file_of(announced_serial);
  if (!is_there(serial)) return refuse(context, "Couldn't find a device with that serial\n");
  if (says(serial, "busy")) return refuse(context, "Could not claim interface on camera: -6\n");
  const bool wants_motor = context->parts & FREENECT_DEVICE_MOTOR;
  if (wants_motor && says(serial, "no_motor")) return refuse(context, "Could not open motor: -4\n");
  take_time_to_open(serial);
  transfer(serial);
  auto* made = new freenect_device;
  made->context = context;
  made->serial = serial;
  made->has_motor = wants_motor;
  context->devices.push_back(made);
  *device = made;
  return 0;
}

int freenect_close_device(freenect_device* device) {
  std::erase(device->context->devices, device);
  delete device;
  return 0;
}

void freenect_set_user(freenect_device* device, void* user) {
  device->user = user;
}
void* freenect_get_user(freenect_device* device) {
  return device->user;
}
void freenect_set_depth_callback(freenect_device* device, freenect_depth_cb callback) {
  device->on_depth = callback;
}
void freenect_set_video_callback(freenect_device* device, freenect_video_cb callback) {
  device->on_video = callback;
}

int freenect_start_depth(freenect_device* device) {
  return start(device, device->depth, microseconds(0));
}
int freenect_start_video(freenect_device* device) {
  return start(device, device->video, microseconds(9000));
}
int freenect_stop_depth(freenect_device* device) {
  transfer(device->serial);
  const bool running = device->depth.running;
  device->depth.running = false;
  return running ? 0 : -1;
}
int freenect_stop_video(freenect_device* device) {
  transfer(device->serial);
  const bool running = device->video.running;
  device->video.running = false;
  return running ? 0 : -1;
}

freenect_registration freenect_copy_registration(freenect_device*) {
  freenect_registration registration{};
  registration.raw_to_mm_shift = new std::uint16_t[2048];
  for (int disparity = 0; disparity < 2048; ++disparity)
    registration.raw_to_mm_shift[disparity] = fake::depth_of_disparity(disparity);
  return registration;
}
int freenect_destroy_registration(freenect_registration* registration) {
  delete[] registration->raw_to_mm_shift;
  registration->raw_to_mm_shift = nullptr;
  return 0;
}

freenect_frame_mode freenect_find_depth_mode(freenect_resolution resolution, freenect_depth_format format) {
  if (resolution != FREENECT_RESOLUTION_MEDIUM) return {};
  auto mode = mode_of(2 * fake::kWidth * fake::kHeight, fake::kHeight, 30);
  mode.depth_format = format;
  return mode;
}
int freenect_set_depth_mode(freenect_device* device, const freenect_frame_mode mode) {
  if (device->depth.running) return -1;
  device->depth_format = mode.depth_format;
  return 0;
}
freenect_frame_mode freenect_find_video_mode(freenect_resolution resolution, freenect_video_format format) {
  if (resolution != FREENECT_RESOLUTION_MEDIUM) return {};
  const bool infrared = format == FREENECT_VIDEO_IR_8BIT;
  auto mode = infrared ? mode_of(fake::kWidth * 488, 488, 30)
                       : mode_of(3 * fake::kWidth * fake::kHeight, fake::kHeight, 30);
  mode.video_format = format;
  return mode;
}
int freenect_set_video_mode(freenect_device* device, freenect_frame_mode mode) {
  if (device->video.running) return -1;
  device->video_format = mode.video_format;
  return 0;
}

int freenect_set_flag(freenect_device* device, freenect_flag flag, freenect_flag_value) {
  transfer(device->serial);
  if (flag == FREENECT_NEAR_MODE && !says(device->serial, "windows"))
    return refuse(device->context, "near mode is only available on a K4W\n");
  return device->dead ? -1 : 0;
}

int freenect_update_tilt_state(freenect_device* device) {
  transfer(device->serial);
  return device->has_motor && !device->dead ? 0 : -1;
}
freenect_raw_tilt_state* freenect_get_tilt_state(freenect_device* device) {
  return &device->tilt;
}
double freenect_get_tilt_degs(freenect_raw_tilt_state* state) {
  return state->tilt_angle / 2.0;
}
int freenect_set_tilt_degs(freenect_device* device, double degrees) {
  transfer(device->serial);
  if (!device->has_motor || device->dead) return -1;
  device->tilt.tilt_angle = static_cast<std::int8_t>(degrees * 2);
  return 0;
}
int freenect_set_led(freenect_device* device, freenect_led_options) {
  transfer(device->serial);
  return device->has_motor && !device->dead ? 0 : -1;
}

}  // extern "C"
