#pragma once

// Base of a device whose streams are PushStreams with one mode each. A camera's class implements
// begin() and end(), its own properties and the virtual functions below.
// Thread: OpenNI2 calls a device from the threads of its users.

#include <deque>
#include <vector>

#include "capture_server/drivers/contract/push_stream.h"

namespace copresence::drivers {

class PushDevice : public oni::driver::DeviceBase, public StreamOwner {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) final;
  /// Returns null if the device has no such sensor.
  oni::driver::StreamBase* createStream(OniSensorType type) final;
  void destroyStream(oni::driver::StreamBase* stream) final { delete stream; }
  /// True if getProperty() succeeds. A device whose getProperty() has to ask the hardware overrides
  /// this function.
  OniBool isPropertySupported(int property) override;

 protected:
  /// `max_depth` is greater than every depth value.
  PushDevice(int width, int height, int frames_per_second, int max_depth);

  /// Adds a sensor with the device's size and rate.
  void add_sensor(OniSensorType type, OniPixelFormat format);

  /// The intrinsics of a new stream.
  virtual Lens lens_of(OniSensorType type) const = 0;

 private:
  const OniVideoMode common_mode_;
  const int max_depth_;
  std::deque<OniVideoMode> modes_;  // A deque keeps its elements in place for the pointers in sensors_.
  std::vector<OniSensorInfo> sensors_;
};

}  // namespace copresence::drivers
