#pragma once

// Converts depth images to pictures for a video codec, and back. Encoder and Decoder offer all
// codecs of docs/internals/codecs.md. The stream description has the codec's name and parameters.
//
// Every codec keeps states exactly: a hole is never decoded as depth, nor depth as a hole. All
// decoded depth lies within the stream's range. Each codec's header file states its coding error.
// Depth is in the stream's DepthUnit along the optical axis. Thread: distinct objects are
// independent; one object is used by one thread at a time.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "common/depth/depth_format.h"
#include "common/frame/coded_frame.h"
#include "common/frame/image.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::depth {

/// The names that Encoder::open() accepts. The first name is the best for most uses.
std::span<const std::string_view> codec_names();

class Encoder {
 public:
  /// Fails with kInvalid for an unknown name, and as check(DepthFormat) does.
  static Result<Encoder> open(std::string_view codec_name, const DepthFormat& format);
  ~Encoder();
  Encoder(Encoder&&) noexcept;
  Encoder& operator=(Encoder&&) noexcept;

  const DepthCodecDescription& description() const;

  /// Sets the depths that the sensor can report, ascending, in the stream's unit. Call this before
  /// the first frame. The codebook, if any, begins with these levels. The list may be incomplete.
  void set_sensor_levels(std::span<const std::uint16_t> levels);

  /// Switches lossless coding on or off. The next frame becomes a keyframe. Codecs with monochrome
  /// pictures then write residuals instead of pictures (residual_coder.h). With other codecs, the
  /// video codec must code the pictures losslessly. Initially off.
  void set_lossless(bool lossless);

  /// Sets the bitrate of depth at a frame rate. No bitrate means a constant QP, which is the
  /// default. The codec `adaptive` spaces its codes accordingly from its next keyframe on. Requires
  /// frames_per_second > 0.
  void set_bitrate(std::optional<int> kbps, double frames_per_second);

  /// Converts depth and states to a picture and side data. Depth 0 and depth outside the range
  /// become holes. The result is a keyframe if `keyframe` is set, for the first frame, or if the
  /// codec decides so. Requires images of the format's shape. Fails with kUnsupported if lossless
  /// coding is impossible for this depth; the next frame is then a keyframe.
  Result<PlanarDepth> encode(const DepthImage& depth, const StateImage& states, bool keyframe);

 private:
  struct Parts;
  explicit Encoder(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

class Decoder {
 public:
  /// `description` may come from an untrusted peer. Fails with kInvalid for an unknown name or
  /// impossible parameters, and as check(DepthFormat) does.
  static Result<Decoder> open(const DepthCodecDescription& description, const DepthFormat& format);
  ~Decoder();
  Decoder(Decoder&&) noexcept;
  Decoder& operator=(Decoder&&) noexcept;

  /// Decodes depth and states. Depth is 0 exactly where the state is kHole. Requires all frames
  /// since the last keyframe, undamaged and in the order of encoding; video::FrameDecoder checks
  /// this. Damaged bytes decode to wrong depth or fail. Fails with kCorrupt for side data that no
  /// encoder writes, and for a picture of another format or shape. After a failure, every frame up
  /// to the next keyframe fails, and `depth` and `states` are unspecified.
  Result<void> decode(const PlanarDepth& planes, DepthImage& depth, StateImage& states);

 private:
  struct Parts;
  explicit Decoder(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace copresence::depth
