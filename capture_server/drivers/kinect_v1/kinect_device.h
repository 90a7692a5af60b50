#pragma once

// One Kinect v1 as a device of OpenNI2. All streams have 640x480 pixels and 30 frames a second.
// Depth is in 1 mm, optionally registered to colour. The second camera gives either colour (RGB888)
// or infrared (GRAY8). The device also has tilt, light, near mode, exposure and white balance.
// Thread: OpenNI2 calls a device from the threads of its users. Pictures come from its own thread.

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "capture_server/drivers/contract/push_device.h"
#include "capture_server/drivers/kinect_v1/device_clock.h"
#include "capture_server/drivers/kinect_v1/freenect_thread.h"
#include "common/result.h"

namespace copresence::drivers {

class KinectDevice final : public PushDevice {
 public:
  using Explain = std::function<void(const std::string&)>;  ///< Appends a sentence to OpenNI2's last error.

  /// Fails as FreenectThread::open() does.
  static Result<std::unique_ptr<KinectDevice>> open(const std::string& serial, std::function<void()> on_lost,
                                                    Explain explain);

  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override;

  OniStatus begin(PushStream& stream) override;
  void end(PushStream& stream) override;
  OniStatus get_of(PushStream& stream, int property, void* data, int* size) override;
  OniStatus set_of(PushStream& stream, int property, const void* data, int size) override;

 private:
  // A started stream and the number of its pictures.
  struct Running {
    PushStream* stream = nullptr;
    int index = 0;
    std::uint64_t last_us = 0;
  };

  KinectDevice(std::string serial, Explain explain);
  bool start_depth();
  bool stop_depth();
  bool depth_is_started();
  bool start_video(bool infrared);
  void deliver(bool is_depth, const void* picture, std::uint32_t ticks);
  OniStatus set_registration(int mode);
  OniStatus set_projector(bool shines);
  OniStatus set_flag(freenect_flag flag, bool on, const char* what);
  Lens lens_of(OniSensorType type) const override;
  Lens depth_lens() const;  // Requires settings_.
  OniStatus depth_of_disparity(void* data, int* size);

  const std::string serial_;
  const Explain explain_;

  mutable std::mutex settings_;  // Guards the five flags below.
  bool registered_ = false, projector_ = true;
  bool near_mode_ = false, auto_exposure_ = true, auto_white_balance_ = true;

  std::mutex running_mutex_;
  Running depth_, video_;
  DeviceClock clock_;
  std::unique_ptr<FreenectThread> thread_;  // As the last member, the thread is destroyed first.
};

}  // namespace copresence::drivers
