#include "capture_server/drivers/kinect_v1/kinect_device.h"

#include <libfreenect_registration.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

namespace copresence::drivers {
namespace {

constexpr int kWidth = 640, kHeight = 480, kFps = 30;
constexpr int kMaxDepth = FREENECT_DEPTH_MM_MAX_VALUE + 1;  // A bound above all depth values.
constexpr std::int64_t kPeriodUs = 1'000'000 / kFps;
constexpr double kMostTilt = 30;
constexpr int kDisparities = 2048;  // Disparities have 11 bits.

// Nominal fields of view in radians, without a calibration of the device. The focal lengths are
// 575.8 px for depth (a PrimeSense sensor's) and 525 px for colour (OpenKinect, ROS openni_camera).
constexpr Lens kDepthLens{1.0144686f, 0.7898090f, {}};
constexpr Lens kColorLens{1.0942216f, 0.8579859f, {}};

std::int64_t host_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Result<std::unique_ptr<KinectDevice>> KinectDevice::open(const std::string& serial,
                                                         std::function<void()> on_lost, Explain explain) {
  std::unique_ptr<KinectDevice> made(new KinectDevice(serial, std::move(explain)));
  auto thread = FreenectThread::open(serial, std::move(on_lost));
  if (!thread) return fail(thread.error());
  made->thread_ = std::move(*thread);
  made->thread_->run([device = made.get()](freenect_device* kinect) {
    freenect_set_user(kinect, device);
    freenect_set_depth_callback(kinect, [](freenect_device* from, void* picture, std::uint32_t ticks) {
      static_cast<KinectDevice*>(freenect_get_user(from))->deliver(true, picture, ticks);
    });
    freenect_set_video_callback(kinect, [](freenect_device* from, void* picture, std::uint32_t ticks) {
      static_cast<KinectDevice*>(freenect_get_user(from))->deliver(false, picture, ticks);
    });
    return 0;
  });
  return made;
}

KinectDevice::KinectDevice(std::string serial, Explain explain)
    : PushDevice(kWidth, kHeight, kFps, kMaxDepth), serial_(std::move(serial)), explain_(std::move(explain)) {
  add_sensor(ONI_SENSOR_DEPTH, ONI_PIXEL_FORMAT_DEPTH_1_MM);
  add_sensor(ONI_SENSOR_COLOR, ONI_PIXEL_FORMAT_RGB888);
  add_sensor(ONI_SENSOR_IR, ONI_PIXEL_FORMAT_GRAY8);
}

Lens KinectDevice::lens_of(OniSensorType type) const {
  const std::lock_guard lock(settings_);
  return type == ONI_SENSOR_DEPTH ? depth_lens() : type == ONI_SENSOR_COLOR ? kColorLens : kDepthLens;
}

Lens KinectDevice::depth_lens() const {
  return registered_ ? kColorLens : kDepthLens;
}

void KinectDevice::deliver(bool is_depth, const void* picture, std::uint32_t ticks) {
  std::optional<PushStream::Picture> sent;
  std::uint64_t now_us;
  int index;
  {
    const std::lock_guard lock(running_mutex_);  // With this lock, a stream that ends waits for its picture.
    Running& running = is_depth ? depth_ : video_;
    now_us = clock_.to_us(ticks, host_us());
    if (!running.stream) return;
    const auto passed = running.index > 0 ? static_cast<std::int64_t>(now_us - running.last_us) : kPeriodUs;
    running.index += std::max(1, static_cast<int>((passed + kPeriodUs / 2) / kPeriodUs));
    running.last_us = now_us;
    index = running.index;
    sent = running.stream->next_picture();
  }
  if (!sent) return;
  // An infrared picture has eight rows more than OpenNI2's mode. The last rows are dropped.
  const auto bytes = sent->pixels<std::byte>();
  std::memcpy(bytes.data(), picture, bytes.size());
  sent->send(now_us, index);
}

bool KinectDevice::start_depth() {
  const auto format = registered_ ? FREENECT_DEPTH_REGISTERED : FREENECT_DEPTH_MM;
  return thread_->run([format](freenect_device* kinect) {
    const auto mode = freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, format);
    if (!mode.is_valid || freenect_set_depth_mode(kinect, mode) < 0) return -1;
    return freenect_start_depth(kinect);
  }) >= 0;
}

bool KinectDevice::stop_depth() {
  return thread_->run([](freenect_device* kinect) { return freenect_stop_depth(kinect); }) >= 0;
}

bool KinectDevice::depth_is_started() {
  const std::lock_guard lock(running_mutex_);
  return depth_.stream != nullptr;
}

bool KinectDevice::start_video(bool infrared) {
  const auto format = infrared ? FREENECT_VIDEO_IR_8BIT : FREENECT_VIDEO_RGB;
  return thread_->run([format](freenect_device* kinect) {
    const auto mode = freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, format);
    if (!mode.is_valid || freenect_set_video_mode(kinect, mode) < 0) return -1;
    return freenect_start_video(kinect);
  }) >= 0;
}

OniStatus KinectDevice::begin(PushStream& stream) {
  const std::lock_guard lock(settings_);
  const bool is_depth = stream.type() == ONI_SENSOR_DEPTH;
  Running& running = is_depth ? depth_ : video_;
  {
    const std::lock_guard running_lock(running_mutex_);
    if (running.stream) {
      explain_(
          "a Kinect sends either colour or infrared, and each picture once: stop the other stream first");
      return ONI_STATUS_OUT_OF_FLOW;
    }
    running = {&stream, 0, 0};
  }
  if (is_depth && !projector_) return ONI_STATUS_OK;  // set_projector() starts the stream later.
  if (is_depth ? start_depth() : start_video(stream.type() == ONI_SENSOR_IR)) return ONI_STATUS_OK;
  explain_(
      "the Kinect does not start its transfers; it needs a USB controller of its own and its power supply");
  const std::lock_guard running_lock(running_mutex_);
  running = {};
  return ONI_STATUS_ERROR;
}

void KinectDevice::end(PushStream& stream) {
  const std::lock_guard lock(settings_);
  const bool is_depth = stream.type() == ONI_SENSOR_DEPTH;
  {
    const std::lock_guard running_lock(running_mutex_);
    (is_depth ? depth_ : video_) = {};
  }
  thread_->run([is_depth](freenect_device* kinect) {
    return is_depth ? freenect_stop_depth(kinect) : freenect_stop_video(kinect);
  });
}

OniBool KinectDevice::isImageRegistrationModeSupported(OniImageRegistrationMode mode) {
  return mode == ONI_IMAGE_REGISTRATION_OFF || mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
}

OniStatus KinectDevice::set_registration(int mode) {
  if (!isImageRegistrationModeSupported(static_cast<OniImageRegistrationMode>(mode)))
    return ONI_STATUS_NOT_SUPPORTED;
  const std::lock_guard lock(settings_);
  const bool wanted = mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  if (wanted == registered_) return ONI_STATUS_OK;
  registered_ = wanted;
  if (!depth_is_started() || !projector_) return ONI_STATUS_OK;
  stop_depth();
  return start_depth() ? ONI_STATUS_OK : ONI_STATUS_ERROR;
}

// libfreenect has no switch for the projector, but the projector is on only while depth is sent.
OniStatus KinectDevice::set_projector(bool shines) {
  const std::lock_guard lock(settings_);
  if (shines == projector_) return ONI_STATUS_OK;
  if (depth_is_started() && !(shines ? start_depth() : stop_depth())) return ONI_STATUS_ERROR;
  projector_ = shines;
  return ONI_STATUS_OK;
}

OniStatus KinectDevice::set_flag(freenect_flag flag, bool on, const char* what) {
  const int done = thread_->run([&](freenect_device* kinect) {
    return freenect_set_flag(kinect, flag, on ? FREENECT_ON : FREENECT_OFF);
  });
  if (done >= 0) return ONI_STATUS_OK;
  explain_(std::string("this Kinect does not accept the setting ") + what);
  return ONI_STATUS_NOT_SUPPORTED;
}

OniBool KinectDevice::isPropertySupported(int property) {
  switch (property) {
    case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION:
    case ONI_DEVICE_PROPERTY_SERIAL_NUMBER:
    case kTilt:
    case kLight:
    case kNearMode:
    case kProjector:
      return TRUE;
    default:
      return FALSE;
  }
}

OniStatus KinectDevice::getProperty(int property, void* data, int* size) {
  if (property == ONI_DEVICE_PROPERTY_SERIAL_NUMBER)
    return answer(serial_.c_str(), static_cast<int>(serial_.size()) + 1, data, size);
  if (property == kTilt) {
    double degrees = 0;
    const int done = thread_->run([&](freenect_device* kinect) {
      if (freenect_update_tilt_state(kinect) < 0) return -1;
      degrees = freenect_get_tilt_degs(freenect_get_tilt_state(kinect));
      return 0;
    });
    return done < 0 ? ONI_STATUS_NOT_SUPPORTED : answer(&degrees, sizeof(degrees), data, size);
  }
  const std::lock_guard lock(settings_);
  if (property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) {
    const int mode = registered_ ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR : ONI_IMAGE_REGISTRATION_OFF;
    return answer(&mode, sizeof(mode), data, size);
  }
  if (property == kNearMode || property == kProjector) {
    const int on = property == kNearMode ? near_mode_ : projector_;
    return answer(&on, sizeof(on), data, size);
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

OniStatus KinectDevice::setProperty(int property, const void* data, int size) {
  if (property == kTilt) {
    const auto degrees = read_as<double>(data, size);
    if (!degrees || !(std::abs(*degrees) <= kMostTilt)) return ONI_STATUS_BAD_PARAMETER;
    const int done =
        thread_->run([&](freenect_device* kinect) { return freenect_set_tilt_degs(kinect, *degrees); });
    return done < 0 ? ONI_STATUS_NOT_SUPPORTED : ONI_STATUS_OK;
  }
  const auto number = read_as<int>(data, size);
  if (!number) return ONI_STATUS_BAD_PARAMETER;
  switch (property) {
    case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION:
      return set_registration(*number);
    case kProjector:
      return set_projector(*number != 0);
    case kLight: {
      if (*number < LED_OFF || *number > LED_BLINK_RED_YELLOW || *number == 5)
        return ONI_STATUS_BAD_PARAMETER;
      const int done = thread_->run([&](freenect_device* kinect) {
        return freenect_set_led(kinect, static_cast<freenect_led_options>(*number));
      });
      return done < 0 ? ONI_STATUS_NOT_SUPPORTED : ONI_STATUS_OK;
    }
    case kNearMode: {
      const OniStatus set =
          set_flag(FREENECT_NEAR_MODE, *number != 0, "near mode: only a Kinect for Windows has it");
      const std::lock_guard lock(settings_);
      if (set == ONI_STATUS_OK) near_mode_ = *number != 0;
      return set;
    }
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

// libfreenect computes millimetres with this table, whether depth is registered or not.
OniStatus KinectDevice::depth_of_disparity(void* data, int* size) {
  std::vector<std::uint16_t> table;
  thread_->run([&](freenect_device* kinect) {
    freenect_registration registration = freenect_copy_registration(kinect);
    if (registration.raw_to_mm_shift)
      table.assign(registration.raw_to_mm_shift, registration.raw_to_mm_shift + kDisparities);
    return freenect_destroy_registration(&registration);
  });
  if (table.empty()) return ONI_STATUS_NOT_SUPPORTED;
  return answer(table.data(), static_cast<int>(table.size() * sizeof(table[0])), data, size);
}

OniStatus KinectDevice::get_of(PushStream& stream, int property, void* data, int* size) {
  if (stream.type() == ONI_SENSOR_DEPTH) {
    if (property == kDepthOfDisparity) return depth_of_disparity(data, size);
    const std::lock_guard lock(settings_);
    const Lens lens = depth_lens();
    if (property == ONI_STREAM_PROPERTY_HORIZONTAL_FOV)
      return answer(&lens.horizontal_fov, sizeof(float), data, size);
    if (property == ONI_STREAM_PROPERTY_VERTICAL_FOV)
      return answer(&lens.vertical_fov, sizeof(float), data, size);
    return ONI_STATUS_NOT_SUPPORTED;
  }
  if (stream.type() != ONI_SENSOR_COLOR) return ONI_STATUS_NOT_SUPPORTED;
  const std::lock_guard lock(settings_);
  const OniBool exposure = auto_exposure_, white_balance = auto_white_balance_;
  if (property == ONI_STREAM_PROPERTY_AUTO_EXPOSURE) return answer(&exposure, sizeof(exposure), data, size);
  if (property == ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE)
    return answer(&white_balance, sizeof(white_balance), data, size);
  return ONI_STATUS_NOT_SUPPORTED;
}

OniStatus KinectDevice::set_of(PushStream& stream, int property, const void* data, int size) {
  const bool exposure = property == ONI_STREAM_PROPERTY_AUTO_EXPOSURE;
  if (stream.type() != ONI_SENSOR_COLOR || (!exposure && property != ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE))
    return ONI_STATUS_NOT_SUPPORTED;
  const auto on = read_as<OniBool>(data, size);
  if (!on) return ONI_STATUS_BAD_PARAMETER;
  const OniStatus set = exposure ? set_flag(FREENECT_AUTO_EXPOSURE, *on, "automatic exposure")
                                 : set_flag(FREENECT_AUTO_WHITE_BALANCE, *on, "automatic white balance");
  const std::lock_guard lock(settings_);
  if (set == ONI_STATUS_OK) (exposure ? auto_exposure_ : auto_white_balance_) = *on != 0;
  return set;
}

}  // namespace copresence::drivers
