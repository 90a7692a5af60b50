#pragma once

// Base of a device whose streams are PushStreams of one mode each. Cameras implement begin() and
// end(), their own properties and the virtual functions below.
//
// Thread: OpenNI2 calls it from the threads of its users.

#include <deque>
#include <vector>

#include "capture_server/drivers/contract/push_stream.h"

namespace copresence::drivers {

class PushDevice : public oni::driver::DeviceBase, public StreamOwner {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) final;
  /// Null if the device has no such sensor.
  oni::driver::StreamBase* createStream(OniSensorType type) final;
  void destroyStream(oni::driver::StreamBase* stream) final { delete stream; }
  /// Whether getProperty() succeeds. A device that has to ask its hardware overrides this.
  OniBool isPropertySupported(int property) override;

 protected:
  /// `max_depth`: greater than every depth pixel's value.
  PushDevice(int width, int height, int frames_per_second, int max_depth);

  /// Adds a sensor with the device's size and rate.
  void add_sensor(OniSensorType type, OniPixelFormat format);

  /// The lens of a new stream.
  virtual Lens lens_of(OniSensorType type) const = 0;

 private:
  const OniVideoMode common_mode_;
  const int max_depth_;
  std::deque<OniVideoMode> modes_;  // a deque: sensors_ points to its elements
  std::vector<OniSensorInfo> sensors_;
};

}  // namespace copresence::drivers
