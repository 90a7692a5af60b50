#pragma once

// A stream to which the camera's driver pushes whole pictures, with the properties that all such
// streams have in common. A picture is written directly into OpenNI2's memory, without a copy.
//
// Thread: OpenNI2 calls properties, start() and stop() from the threads of its users; pictures come
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

/// Copies `size` bytes out by the rules of OpenNI2's properties. Any size is allowed: callers are
/// untrusted.
OniStatus answer(const void* value, int size, void* data, int* data_size);

/// The value of a property that is being set; nothing if its size is wrong.
template <class Value>
std::optional<Value> read_as(const void* data, int size) {
  Value value;
  if (!data || size != sizeof(value)) return std::nullopt;
  std::memcpy(&value, data, sizeof(value));
  return value;
}

struct Lens {
  float horizontal_fov = 0, vertical_fov = 0;  ///< radians
  std::optional<Intrinsics> intrinsics;        ///< if known
};

class PushStream;

/// The device of a stream, which starts and stops the camera.
class StreamOwner {
 public:
  virtual OniStatus begin(PushStream& stream) = 0;
  /// Called only after a successful begin(); never fails.
  virtual void end(PushStream& stream) = 0;
  /// This camera's properties beyond the common ones, or instead of them.
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
  /// `max_value`: greater than every pixel, as OpenNI2's depth recorder requires; 0 for colour.
  PushStream(StreamOwner& owner, OniSensorType type, std::vector<OniVideoMode> modes, int max_value);
  ~PushStream() override;

  OniSensorType type() const { return type_; }
  OniVideoMode mode() const;
  void set_lens(const Lens& lens);

  /// One picture: obtain it, write it, send it. A picture that is not sent is given back to
  /// OpenNI2. While a picture exists, stop() waits for it, so the stream cannot disappear. The
  /// stream holds no lock meanwhile, since OpenNI2 calls stop() and properties under locks of its
  /// own. A device may hold a lock in next_picture(), which asks OpenNI2 for memory, but not in
  /// send().
  class Picture {
   public:
    /// All pixels, row by row from the top; unspecified before they are written. Requires a `Pixel`
    /// of the mode's size.
    template <class Pixel>
    std::span<Pixel> pixels() {
      return {static_cast<Pixel*>(frame_->data), static_cast<std::size_t>(frame_->dataSize) / sizeof(Pixel)};
    }

    /// Passes it to OpenNI2's listeners. It must not be used afterwards. `index` counts the
    /// camera's pictures from 1; a gap means lost pictures.
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

  /// Nothing if the stream is stopped or OpenNI2 has no memory. Requires that the calling thread
  /// has no other picture of this stream.
  std::optional<Picture> next_picture();

  OniStatus start() override;
  void stop() override;
  int getRequiredFrameSize() override;
  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;

 private:
  int row_bytes() const;
  void no_picture();    // marks that there is no picture
  bool end_pictures();  // waits for the present picture; false if the stream did not run

  StreamOwner& owner_;
  const OniSensorType type_;
  const std::vector<OniVideoMode> modes_;
  const int max_value_;
  mutable std::mutex mutex_;  // guards all below; never held while OpenNI2 or the owner is called
  std::condition_variable given_back_;
  OniVideoMode mode_;
  Lens lens_;
  bool running_ = false;
  bool on_its_way_ = false;  // a picture exists
};

}  // namespace copresence::drivers
