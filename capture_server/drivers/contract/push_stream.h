#pragma once

// A stream of a driver that pushes whole pictures as its camera delivers them, and the properties that every such stream
// answers in the same way.
//
// Thread: OpenNI2 calls properties, start() and stop() from its users' threads; push() comes from the camera's thread.
// After stop() has returned, no push() of this stream reaches OpenNI2.

#include <cstdint>
#include <cstring>
#include <mutex>
#include <optional>
#include <vector>

#include "capture_server/drivers/contract/device_properties.h"
#include "capture_server/drivers/contract/open_ni_driver.h"

namespace copresence::drivers {

/// Copies `size` bytes out as OpenNI2's properties go. Requires nothing: sizes come from strangers.
OniStatus answer(const void* value, int size, void* data, int* data_size);

/// What somebody set as a property; nothing where its size is another.
template <class Value>
std::optional<Value> read_as(const void* data, int size) {
  Value value;
  if (!data || size != sizeof(value)) return std::nullopt;
  std::memcpy(&value, data, sizeof(value));
  return value;
}

struct Lens {
  float horizontal_fov = 0, vertical_fov = 0;  ///< radians
  std::optional<Intrinsics> intrinsics;        ///< where more is known
};

class PushStream;

/// The device that a stream belongs to: it begins and ends the camera's work.
class StreamOwner {
 public:
  virtual OniStatus begin(PushStream& stream) = 0;
  /// Only after a begin() that succeeded; never fails.
  virtual void end(PushStream& stream) = 0;
  /// Properties that this camera's streams have beyond the common ones, or instead of them.
  virtual OniStatus get_of(PushStream&, int /*property*/, void* /*data*/, int* /*size*/) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  virtual OniStatus set_of(PushStream&, int /*property*/, const void* /*data*/, int /*size*/) {
    return ONI_STATUS_NOT_SUPPORTED;
  }

 protected:
  ~StreamOwner() = default;
};

class PushStream : public oni::driver::StreamBase {
 public:
  /// `max_value`: greater than every pixel's, which OpenNI2's depth recorder relies on; 0 for colour.
  PushStream(StreamOwner& owner, OniSensorType type, std::vector<OniVideoMode> modes, int max_value);
  ~PushStream() override;

  OniSensorType type() const { return type_; }
  OniVideoMode mode() const;
  void set_lens(const Lens& lens);

  /// Hands one picture to whoever listens. `index` counts the camera's pictures from 1: a gap says that some were lost.
  /// Returns false when the stream is stopped or `bytes` are not what its mode has.
  bool push(const void* picture, int bytes, std::uint64_t timestamp_us, int index);

  OniStatus start() override;
  void stop() override;
  int getRequiredFrameSize() override;
  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;

 private:
  int row_bytes() const;

  StreamOwner& owner_;
  const OniSensorType type_;
  const std::vector<OniVideoMode> modes_;
  const int max_value_;
  mutable std::mutex mutex_;  // of the mode and the lens
  OniVideoMode mode_;
  Lens lens_;
  std::mutex pushing_;  // held while a picture is handed over, and to stop
  bool running_ = false;
};

}  // namespace copresence::drivers
