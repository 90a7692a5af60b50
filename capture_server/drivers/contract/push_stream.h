#pragma once

// A stream of a driver that pushes whole pictures as its camera delivers them, and the properties that every such stream
// answers in the same way. A picture is written where OpenNI2 keeps it: nothing is copied on the way.
//
// Thread: OpenNI2 calls properties, start() and stop() from its users' threads; pictures come from the camera's thread.
// After stop() has returned, no picture of this stream reaches OpenNI2.

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

  /// One picture on its way: to be written, then sent. What is not sent is given back. As long as there is one, stop()
  /// waits for it, so its stream stays. The stream holds no lock meanwhile, since OpenNI2 calls stop() and properties under
  /// locks of its own. A device may hold a lock while next_picture() asks OpenNI2 for memory, but none when it sends.
  class Picture {
   public:
    /// All of it, row by row from the top, its values unspecified before they are written. Requires a `Pixel` of the mode's size.
    template <class Pixel>
    std::span<Pixel> pixels() {
      return {static_cast<Pixel*>(frame_->data), static_cast<std::size_t>(frame_->dataSize) / sizeof(Pixel)};
    }

    /// Hands it to whoever listens; then it is no longer ours. `index` counts the camera's pictures from 1: a gap says that some
    /// were lost.
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

  /// Nothing when the stream is stopped, or OpenNI2 has no memory for it. Requires that its thread has no other one of this stream.
  std::optional<Picture> next_picture();

  OniStatus start() override;
  void stop() override;
  int getRequiredFrameSize() override;
  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;

 private:
  int row_bytes() const;
  void no_picture();    // none is on its way
  bool end_pictures();  // waits for the one on its way; false where the stream did not run

  StreamOwner& owner_;
  const OniSensorType type_;
  const std::vector<OniVideoMode> modes_;
  const int max_value_;
  mutable std::mutex mutex_;  // of all below; never held while OpenNI2 or the owner is called
  std::condition_variable given_back_;
  OniVideoMode mode_;
  Lens lens_;
  bool running_ = false;
  bool on_its_way_ = false;  // there is a picture
};

}  // namespace copresence::drivers
