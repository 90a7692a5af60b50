#include "capture_server/drivers/contract/push_device.h"

namespace copresence::drivers {

PushDevice::PushDevice(int width, int height, int frames_per_second, int max_depth)
    : common_mode_{ONI_PIXEL_FORMAT_DEPTH_1_MM, width, height, frames_per_second}, max_depth_(max_depth) {}

void PushDevice::add_sensor(OniSensorType type, OniPixelFormat format) {
  modes_.push_back(common_mode_);
  modes_.back().pixelFormat = format;
  sensors_.push_back({type, 1, &modes_.back()});
}

OniStatus PushDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
  *sensors = sensors_.data();
  *count = static_cast<int>(sensors_.size());
  return ONI_STATUS_OK;
}

oni::driver::StreamBase* PushDevice::createStream(OniSensorType type) {
  for (const OniSensorInfo& sensor : sensors_) {
    if (sensor.sensorType != type) continue;
    auto* stream = new PushStream(*this, type, {sensor.pSupportedVideoModes[0]},
                                  type == ONI_SENSOR_DEPTH ? max_depth_ : 0);
    stream->set_lens(lens_of(type));
    return stream;
  }
  return nullptr;
}

OniBool PushDevice::isPropertySupported(int property) {
  alignas(double) char room[ONI_MAX_STR];
  int size = sizeof(room);
  return getProperty(property, room, &size) == ONI_STATUS_OK;
}

}  // namespace copresence::drivers
