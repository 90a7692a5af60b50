#include "capture_server/sensor/device_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/frame_synchronizer.h"
#include "capture_server/sensor/open_ni.h"
#include "capture_server/sensor/projector.h"
#include "capture_server/sensor/reconnecting_source.h"
#include "common/flow/cpu_starvation.h"

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr Duration kStallAfter = std::chrono::seconds(1);
// The first frame takes longer, since a Kinect's projector and exposure have to settle.
constexpr Duration kFirstFrameAfter = std::chrono::seconds(3);
constexpr int kSliceMs = 50;  // Longest delay of a stop request.
// A single wait adds at most this time to the camera's silence. If the wait took longer, the
// process was suspended.
constexpr Duration kMostALook = milliseconds(500);
constexpr std::int64_t kReuseColorUs = 100'000;
constexpr std::uint64_t kSettledAfter = 60;  // In frames.

class GoneListener final : public openni::OpenNI::DeviceDisconnectedListener {
 public:
  explicit GoneListener(std::string uri) : uri_(std::move(uri)) {
    openni::OpenNI::addDeviceDisconnectedListener(this);
  }
  ~GoneListener() override { openni::OpenNI::removeDeviceDisconnectedListener(this); }
  GoneListener(const GoneListener&) = delete;
  GoneListener& operator=(const GoneListener&) = delete;

  bool gone() const { return gone_; }

  void onDeviceDisconnected(const openni::DeviceInfo* device) override {
    if (uri_ == device->getUri()) gone_ = true;
  }

 private:
  const std::string uri_;
  std::atomic<bool> gone_ = false;
};

// The drivers that a process needs for one camera. Installed drivers may serve PrimeSense cameras.
std::string_view drivers_for(std::string_view uri) {
  if (uri.empty()) return drivers::kRealCameras;
  const std::string_view driver = drivers::driver_of(uri);
  return driver == drivers::kPrimeSense ? drivers::kOtherThanKinects : driver;
}

class DeviceSource final : public FrameSource {
 public:
  DeviceSource(std::string uri, const CameraControls& controls)
      : uri_(std::move(uri)), controls_(controls), session_(drivers_for(uri_)) {}

  ~DeviceSource() override {
    if (depth_.isValid()) depth_.stop();
    if (color_.isValid()) color_.stop();
    let_threads_leave();
    // Streams are destroyed before the device is closed. Closing the device frees them, so
    // destroying them later would free them twice.
    color_.destroy();
    depth_.destroy();
    projector_.reset();
    device_.close();
  }

  DeviceSource(const DeviceSource&) = delete;
  DeviceSource& operator=(const DeviceSource&) = delete;

  Result<void> start();
  const SensorDescription& description() const override { return description_; }
  SourceCounters counters() const override;
  Result<RgbdFrame> next(std::stop_token stop) override;

 private:
  // A picture, its time of arrival and its pixels. Pixels are copied on arrival, while the other
  // stream's picture is still on its way. A colour picture that belongs to several frames is copied
  // again for each further frame.
  struct Held {
    openni::VideoFrameRef picture;
    Instant at{};
    std::shared_ptr<RgbdFrame> copy = std::make_shared<RgbdFrame>();
  };
  using Synchronizer = FrameSynchronizer<Held>;

  Result<void> open_stream(openni::VideoStream& stream, openni::SensorType type, int width, int height);
  Result<Synchronizer::Pair> next_pair(const std::stop_token& stop);
  void read(openni::VideoStream& stream);
  Result<void> begin_controls();
  Result<void> begin_projector();
  void fix_controls();

  const std::string uri_;
  const CameraControls controls_;
  const OpenNiSession session_;
  openni::Device device_;
  openni::VideoStream depth_;
  openni::VideoStream color_;
  std::optional<GoneListener> gone_;
  std::optional<Projector> projector_;  // Nothing if projectors do not take turns.

  SensorDescription description_;
  std::int64_t half_period_us_ = 16667;
  std::optional<Synchronizer> synchronizer_;
  Instant color_is_up_by_{};
  int last_index_[2] = {0, 0};  // Frame numbers of depth and of colour.
  SourceCounters counters_;
};

Result<void> DeviceSource::open_stream(openni::VideoStream& stream, openni::SensorType type, int width,
                                       int height) {
  const bool is_depth = type == openni::SENSOR_DEPTH;
  if (stream.create(device_, type) != openni::STATUS_OK) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: its {} stream does not open ({}); unplug the camera and plug it in again",
                            description_.name, is_depth ? "depth" : "colour", last_open_ni_error()));
  }
  const auto mode = choose_mode(stream.getSensorInfo(), is_depth, width, height);
  if (!mode) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: it offers no {} of even size; use another camera", description_.name,
                            is_depth ? "depth in 1 mm or 0.1 mm" : "colour in RGB888"));
  }
  // A device with a single mode may refuse to set that mode.
  if (stream.setVideoMode(*mode) != openni::STATUS_OK && !is_usable(stream.getVideoMode(), is_depth)) {
    return fail(
        ErrorCode::kUnavailable,
        fmt::format(
            "{}: it does not accept the mode {}x{} at {} a second ({}); unplug the camera and plug it in "
            "again",
            description_.name, mode->getResolutionX(), mode->getResolutionY(), mode->getFps(),
            last_open_ni_error()));
  }
  stream.setMirroringEnabled(false);  // A driver in which this call fails cannot mirror at all.
  return {};
}

Result<void> DeviceSource::start() {
  if (!session_.is_up()) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("OpenNI2 does not start: {}; install the package libopenni2-0 again",
                            last_open_ni_error()));
  }
  if (device_.open(uri_.empty() ? openni::ANY_DEVICE : uri_.c_str()) != openni::STATUS_OK) {
    return uri_.empty()
               ? fail(ErrorCode::kNotFound,
                      fmt::format("no camera opens ({}); plug one in, then see capture_server --list",
                                  last_open_ni_error()))
               : fail(ErrorCode::kNotFound,
                      fmt::format("camera {} does not open ({}); see capture_server --list", uri_,
                                  last_open_ni_error()));
  }
  const openni::DeviceInfo& device = device_.getDeviceInfo();
  description_.name = fmt::format("{} {}", device.getVendor(), device.getName());
  description_.uri = device.getUri();
  gone_.emplace(description_.uri);
  if (!device_.hasSensor(openni::SENSOR_DEPTH)) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: it has no depth sensor; use a depth camera", description_.name));
  }
  if (auto opened = open_stream(depth_, openni::SENSOR_DEPTH, 640, 480); !opened) return opened;
  const openni::VideoMode depth_mode = depth_.getVideoMode();
  if (device_.hasSensor(openni::SENSOR_COLOR)) {
    const auto opened =
        open_stream(color_, openni::SENSOR_COLOR, depth_mode.getResolutionX(), depth_mode.getResolutionY());
    // A camera whose colour format is unknown still gives depth.
    if (!opened && opened.error().code != ErrorCode::kUnsupported) return fail(opened.error());
    if (!opened) color_.destroy();
    description_.has_color = opened.has_value();
  }
  if (description_.has_color) {
    constexpr auto kToColor = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    description_.registered = device_.isImageRegistrationModeSupported(kToColor) &&
                              device_.setImageRegistrationMode(kToColor) == openni::STATUS_OK &&
                              device_.getImageRegistrationMode() == kToColor;
    device_.setDepthColorSyncEnabled(true);  // Without hardware sync, frames are paired by time.
    description_.color = camera_of(color_);
  }
  if (auto taken = begin_controls(); !taken) return taken;
  description_.depth = camera_of(depth_);
  description_.world_from_camera = pose_of(device_);
  if (description_.registered) description_.registered = description_.color.width == description_.depth.width;
  description_.unit = depth_mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM
                          ? DepthUnit::k100Micrometres
                          : DepthUnit::kMillimetre;
  description_.levels = levels_of(depth_);
  description_.frames_per_second = std::max(depth_mode.getFps(), 1);
  half_period_us_ = static_cast<std::int64_t>(500'000 / description_.frames_per_second);
  synchronizer_.emplace(half_period_us_, kReuseColorUs);
  if (depth_.start() != openni::STATUS_OK ||
      (description_.has_color && color_.start() != openni::STATUS_OK)) {
    return fail(
        ErrorCode::kUnavailable,
        fmt::format("{}: its streams do not start ({}); unplug the camera and plug it in again, into a USB "
                    "controller of its own",
                    description_.name, last_open_ni_error()));
  }
  color_is_up_by_ = steady_clock::now() + kStallAfter;
  return begin_projector();
}

Result<void> DeviceSource::begin_projector() {
  if (!controls_.projector) return {};
  projector_.emplace(device_, *controls_.projector, std::chrono::microseconds(2 * half_period_us_));
  auto begun = projector_->begin();
  if (begun) return {};
  return fail(begun.error().code, fmt::format("{}: {}", description_.name, begun.error().what));
}

Result<void> DeviceSource::begin_controls() {
  if (!controls_.exposure && !controls_.white_balance) return {};
  openni::CameraSettings* settings = description_.has_color ? color_.getCameraSettings() : nullptr;
  // Automatic exposure and white balance run until fix_controls() fixes the settled values.
  if (!settings || (controls_.exposure && settings->setAutoExposureEnabled(true) != openni::STATUS_OK) ||
      (controls_.white_balance && settings->setAutoWhiteBalanceEnabled(true) != openni::STATUS_OK)) {
    return fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: it offers no control of its exposure or white balance; start without --exposure and "
                    "--white-balance",
                    description_.name));
  }
  return {};
}

void DeviceSource::fix_controls() {
  constexpr auto kFixed = CameraControls::Mode::kFixed;
  openni::CameraSettings* settings = description_.has_color ? color_.getCameraSettings() : nullptr;
  if (!settings) return;
  if (controls_.exposure == kFixed) settings->setAutoExposureEnabled(false);
  if (controls_.white_balance == kFixed) settings->setAutoWhiteBalanceEnabled(false);
}

SourceCounters DeviceSource::counters() const {
  SourceCounters counters = counters_;
  counters.color_without_depth = synchronizer_->unused_color();
  return counters;
}

void DeviceSource::read(openni::VideoStream& stream) {
  Held held;
  if (stream.readFrame(&held.picture) != openni::STATUS_OK) return;
  held.at = steady_clock::now();
  const bool is_depth = &stream == &depth_;
  int& last = last_index_[is_depth ? 0 : 1];
  const int index = held.picture.getFrameIndex();
  if (last > 0 && index > last + 1) counters_.late += static_cast<std::uint64_t>(index - last - 1);
  last = index;
  if (is_depth && projector_ && !projector_->is_exposed(held.at)) {
    ++counters_.projector_off;
    return;
  }
  const auto timestamp_us = static_cast<std::int64_t>(held.picture.getTimestamp());
  const CameraModel& camera = is_depth ? description_.depth : description_.color;
  if (!is_whole(held.picture, camera, is_depth ? 2 : 3)) {
    ++counters_.damaged;
  } else if (is_depth) {
    copy_depth(held.picture, camera, *held.copy);
    held.copy->durations.capture = steady_clock::now() - held.at;
    synchronizer_->add_depth(timestamp_us, std::move(held));
  } else {
    copy_color(held.picture, camera, *held.copy);
    held.copy->durations.capture = steady_clock::now() - held.at;
    synchronizer_->add_color(timestamp_us, std::move(held));
  }
}

Result<DeviceSource::Synchronizer::Pair> DeviceSource::next_pair(const std::stop_token& stop) {
  openni::VideoStream* streams[] = {&depth_, &color_};
  const int stream_count = description_.has_color ? 2 : 1;
  const Duration others = controls_.projector ? Duration(controls_.projector->round()) : Duration(0);
  flow::WatchedTime time;
  const Instant give_up =
      time.look(kMostALook) + others + (counters_.frames ? kStallAfter : kFirstFrameAfter);
  Instant waits_until = Instant::max();  // End of the wait for colour.
  while (true) {
    // A camera may send no depth while its projector is off. The gap in its frame numbers then does
    // not mean a loss.
    if (projector_ && projector_->follow_schedule()) last_index_[0] = 0;
    const Instant now = steady_clock::now();
    const bool may_wait = description_.has_color && now < waits_until;
    if (auto pair = synchronizer_->take(may_wait)) {
      // Depth from before the first colour picture is dropped, so that the first frame has colour.
      const bool too_early =
          description_.has_color && !pair->color && counters_.frames == 0 && now < color_is_up_by_;
      if (!too_early) return std::move(*pair);
      waits_until = Instant::max();
      continue;
    }
    if (synchronizer_->has_depth() && waits_until == Instant::max())
      waits_until = now + std::chrono::microseconds(half_period_us_);
    if (stop.stop_requested()) return fail(ErrorCode::kEndOfStream, "asked to stop");
    if (gone_->gone()) {
      return fail(ErrorCode::kUnavailable, fmt::format("{}: unplugged; plug it in again", description_.name));
    }
    if (time.look(kMostALook) > give_up) {
      return fail(ErrorCode::kTimeout,
                  fmt::format("{}: it sends no frames; unplug it and plug it in again", description_.name));
    }
    const Duration slice = projector_ ? std::min<Duration>(projector_->until_change(), milliseconds(kSliceMs))
                                      : milliseconds(kSliceMs);
    const auto wait_ms = std::chrono::ceil<milliseconds>(
        std::clamp<Duration>(waits_until - now, milliseconds(1), std::max<Duration>(slice, milliseconds(1))));
    int ready = 0;
    if (openni::OpenNI::waitForAnyStream(streams, stream_count, &ready, static_cast<int>(wait_ms.count())) ==
        openni::STATUS_OK) {
      read(*streams[ready]);
    }
  }
}

Result<RgbdFrame> DeviceSource::next(std::stop_token stop) {
  auto pair = next_pair(stop);
  if (!pair) return fail(pair.error());
  RgbdFrame frame = std::move(*pair->depth.copy);
  if (pair->color_again) {
    const Instant begin = steady_clock::now();
    copy_color(pair->color->picture, description_.color, frame);
    frame.durations.capture += steady_clock::now() - begin;
  } else if (pair->color) {
    frame.color = std::move(pair->color->copy->color);
    frame.durations.capture += pair->color->copy->durations.capture;
  }
  frame.sensor_times = Synchronizer::times_of(*pair);
  frame.metadata.sequence = ++counters_.frames;
  if (counters_.frames == kSettledAfter) fix_controls();
  frame.metadata.captured_at = pair->depth.at;
  frame.metadata.world_from_camera = description_.world_from_camera.value_or(Rigid3{});
  if (description_.has_color && !pair->same_instant) ++counters_.depth_without_color;
  return frame;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_device(const std::string& uri, const CameraControls& controls) {
  auto source = std::make_unique<DeviceSource>(uri, controls);
  if (auto started = source->start(); !started) return fail(started.error());
  return source;
}

Result<std::unique_ptr<FrameSource>> open_reconnecting_device(const std::string& uri,
                                                              const CameraControls& controls) {
  // OpenNI2 and its drivers stay active while the camera is absent, to notice its return.
  const auto session = std::make_shared<const OpenNiSession>(drivers_for(uri));
  return ReconnectingSource::open([session, wanted = uri, controls]() mutable {
    auto source = open_device(wanted, controls);
    if (source) wanted = (*source)->description().uri;
    return source;
  });
}

}  // namespace copresence::sensor
