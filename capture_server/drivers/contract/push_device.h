#pragma once

// A device of a driver whose streams are PushStreams of one mode each: what every such device does in the same way. Cameras
// differ in begin() and end(), their properties, and what stands in virtual functions here.
//
// Thread: OpenNI2 calls from its users' threads.

#include <deque>
#include <vector>

#include "capture_server/drivers/contract/push_stream.h"

namespace copresence::drivers {

class PushDevice : public oni::driver::DeviceBase, public StreamOwner {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) final;
  /// Null where the device has no such sensor.
  oni::driver::StreamBase* createStream(OniSensorType type) final;
  void destroyStream(oni::driver::StreamBase* stream) final { delete stream; }
  /// Whether getProperty() answers: a device that has to ask its hardware says it otherwise.
  OniBool isPropertySupported(int property) override;

 protected:
  /// `max_depth`: greater than every depth pixel's value.
  PushDevice(int width, int height, int frames_per_second, int max_depth);

  /// In the device's size and rate.
  void add_sensor(OniSensorType type, OniPixelFormat format);

  /// Of a new stream.
  virtual Lens lens_of(OniSensorType type) const = 0;

 private:
  const OniVideoMode common_mode_;
  const int max_depth_;
  std::deque<OniVideoMode> modes_;  // keeps its elements where they are: sensors_ points to them
  std::vector<OniSensorInfo> sensors_;
};

}  // namespace copresence::drivers
