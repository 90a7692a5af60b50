#pragma once

// Converts depth images to pictures for a video codec, and back. One pair of classes offers all
// codecs of docs/internals/codecs.md. The codec's name and parameters are part of the stream
// description.
//
// Every codec keeps states exactly: a hole is never decoded as depth, nor depth as a hole. All
// decoded depth lies within the stream's range. The codecs' errors are in their own headers and in
// docs/internals/codecs.md.
//
// Units: depth in the stream's DepthUnit along the optical axis. Thread: distinct objects are
// independent; one object is used by one thread at a time.

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/frame/coded_frame.h"
#include "common/frame/image.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::depth {

/// The names that Encoder::open() accepts; the best for most uses is first.
std::span<const std::string_view> codec_names();

class Encoder {
 public:
  /// Fails (kInvalid) on an unknown name, with a sentence that lists the known ones, and as
  /// check(DepthFormat) does.
  static Result<Encoder> open(std::string_view codec_name, const DepthFormat& format);
  ~Encoder();
  Encoder(Encoder&&) noexcept;
  Encoder& operator=(Encoder&&) noexcept;

  const DepthCodecDescription& description() const;

  /// Sets the depths that the sensor can report, ascending, in the stream's unit. Call it before
  /// the first frame. A codec with a codebook then has these levels from the beginning. The list
  /// need not be complete.
  void set_sensor_levels(std::span<const std::uint16_t> levels);

  /// Switches lossless coding on or off from the next frame on, which becomes a keyframe. Codecs
  /// with monochrome pictures then give residuals instead of pictures (residual_coder.h). The
  /// pictures of other codecs must be coded without loss by the video codec. Off at first.
  void set_lossless(bool lossless);

  /// Converts depth and states to a picture and side data. Depth 0 and depth outside the range
  /// become holes, whatever their state. The frame is a keyframe if `keyframe` is set, if it is the
  /// first, or if the codec decides so.
  /// Requires the shape of the format. Fails (kUnsupported) if lossless coding is not possible for
  /// this depth; the next frame is a keyframe then.
  Result<PlanarDepth> encode(const DepthImage& depth, const StateImage& states, bool keyframe);

 private:
  struct Parts;
  explicit Encoder(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

class Decoder {
 public:
  /// `description` may come from an untrusted peer. Fails (kInvalid) on an unknown name, on
  /// impossible parameters, and as check(DepthFormat) does.
  static Result<Decoder> open(const DepthCodecDescription& description, const DepthFormat& format);
  ~Decoder();
  Decoder(Decoder&&) noexcept;
  Decoder& operator=(Decoder&&) noexcept;

  /// Decodes depth and states; depth is 0 exactly where the state is kHole. Requires the frames in
  /// the order of encoding and without gaps since the last keyframe. video::FrameDecoder checks
  /// this, and that the bytes are undamaged; other bytes decode to other depth or fail.
  /// Fails (kCorrupt) on side data that no encoder writes, and on a picture of another format or
  /// shape. Every frame up to the next keyframe fails then, and `depth` and `states` are
  /// unspecified.
  Result<void> decode(const PlanarDepth& planes, DepthImage& depth, StateImage& states);

 private:
  struct Parts;
  explicit Decoder(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace copresence::depth
