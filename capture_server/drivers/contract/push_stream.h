#pragma once

// A stream to which the camera's driver pushes whole pictures, with the properties that all such
// streams share. A picture is written directly into OpenNI2's memory, without a copy.
// Thread: OpenNI2 calls properties, start() and stop() from the threads of its users. Pictures come
// from the camera's thread. After stop() has returned, no picture of this stream reaches OpenNI2.

#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "capture_server/drivers/contract/device_properties.h"
#include "capture_server/drivers/contract/open_ni_driver.h"

namespace copresence::drivers {

/// Copies a property's `size` bytes to a caller of OpenNI2. The caller is untrusted: a
/// `*data_size` below `size` is an error.
OniStatus answer(const void* value, int size, void* data, int* data_size);

/// Returns the value of a property that is being set, or nothing if its size is wrong.
template <class Value>
std::optional<Value> read_as(const void* data, int size) {
  Value value;
  if (!data || size != sizeof(value)) return std::nullopt;
  std::memcpy(&value, data, sizeof(value));
  return value;
}

struct Lens {
  float horizontal_fov = 0, vertical_fov = 0;  ///< In radians.
  std::optional<Intrinsics> intrinsics;        ///< Nothing if intrinsics are unknown.
};

class PushStream;

/// The device of a stream. The device starts and stops the camera.
class StreamOwner {
 public:
  virtual OniStatus begin(PushStream& stream) = 0;
  /// The stream calls end() only after a successful begin(). This function never fails.
  virtual void end(PushStream& stream) = 0;
  /// Reads or writes properties that only this camera has or that replace the common ones.
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
  /// `max_value` exceeds every pixel, as OpenNI2's depth recorder requires, and is 0 for colour.
  PushStream(StreamOwner& owner, OniSensorType type, std::vector<OniVideoMode> modes, int max_value);
  ~PushStream() override;

  OniSensorType type() const { return type_; }
  OniVideoMode mode() const;
  void set_lens(const Lens& lens);

  /// One picture. The driver gets a picture, writes its pixels and sends it. A picture that is not
  /// sent is returned to OpenNI2. While a picture exists, stop() waits for it, so the stream stays
  /// alive. The stream holds no lock during this time, since OpenNI2 calls stop() and properties
  /// under its own locks. A device may hold a lock during next_picture(), but not during send().
  class Picture {
   public:
    /// All pixels of the picture, row by row from the top. The pixels are uninitialised. Requires a
    /// `Pixel` of the mode's size.
    template <class Pixel>
    std::span<Pixel> pixels() {
      return {static_cast<Pixel*>(frame_->data), static_cast<std::size_t>(frame_->dataSize) / sizeof(Pixel)};
    }

    /// Passes the picture to OpenNI2's listeners. The picture must not be used afterwards. `index`
    /// counts the camera's pictures from 1, and a gap means lost pictures.
    void send(std::uint64_t timestamp_us, int index);

   private:
    friend class PushStream;
    struct GiveBack {
      PushStream* stream;
      void operator()(OniFrame* frame) const;
    };
    Picture(PushStream& stream, OniFrame* frame) : frame_(frame, GiveBack{&stream}) {}

    std::unique_ptr<OniFrame, GiveBack> frame_;
  };

  /// Returns nothing if the stream is stopped or OpenNI2 has no memory. Requires that the calling
  /// thread holds no other picture of this stream.
  std::optional<Picture> next_picture();

  OniStatus start() override;
  void stop() override;
  int getRequiredFrameSize() override;
  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;

 private:
  int row_bytes() const;
  void no_picture();    // Records that no picture exists any more.
  bool end_pictures();  // Waits until no picture exists. Returns false if the stream did not run.

  StreamOwner& owner_;
  const OniSensorType type_;
  const std::vector<OniVideoMode> modes_;
  const int max_value_;
  // Guards all members below. The mutex is never held while OpenNI2 or the owner is called.
  mutable std::mutex mutex_;
  std::condition_variable given_back_;
  OniVideoMode mode_;
  Lens lens_;
  bool running_ = false;
  bool on_its_way_ = false;  // True while a picture exists.
};

}  // namespace copresence::drivers
