#pragma once

// Depth as a video codec can carry it, and back. All codecs of docs/internals/codecs.md stand behind one pair of
// classes; which one it is, and its numbers, travel in the stream description.
//
// What every codec keeps: a hole never comes back as depth, nor depth as a hole; states are exact; every
// depth that comes back lies within the stream's range. What a codec keeps beyond that is in its own header
// and in docs/internals/codecs.md.
//
// Units: depth in the stream's DepthUnit along the optical axis. Thread: distinct objects are independent;
// one object is used by one thread at a time.

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

/// The names that Encoder::open takes, best for most uses first.
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

  /// Tells which depths the sensor can report, ascending, in the stream's unit, before the first frame. Codecs with a level table
  /// then have it from the beginning instead of learning it; it need not be complete.
  void set_sensor_levels(std::span<const std::uint16_t> levels);

  /// Tells whether depth is coded without loss from the next frame on, which is a keyframe where that changes. Codecs with monochrome
  /// pictures then give samples (residual_coder.h) instead; the others' pictures must come through video coding as they are. It is
  /// off at first.
  void set_lossless(bool lossless);

  /// Depth and states as pictures and side data. Depth outside the range, and depth 0, is a hole whatever its
  /// state says. The frame is a keyframe where asked for, the first always; a codec may decide so itself.
  /// Requires the shape of the format. Fails (kUnsupported) where the coding is lossless and the codec cannot
  /// be; the next frame is a keyframe then.
  Result<PlanarDepth> encode(const DepthImage& depth, const StateImage& states, bool keyframe);

 private:
  struct Parts;
  explicit Encoder(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

class Decoder {
 public:
  /// `description` as it came from the other side. Fails (kInvalid) on an unknown name, on parameters that
  /// make no sense and as check(DepthFormat) does.
  static Result<Decoder> open(const DepthCodecDescription& description, const DepthFormat& format);
  ~Decoder();
  Decoder(Decoder&&) noexcept;
  Decoder& operator=(Decoder&&) noexcept;

  /// Depth and states back; depth is 0 exactly where the state is kHole.
  /// Fails (kCorrupt) where mask, table or samples are not what was sent, where frames are missing or in another
  /// order, and on a picture of another format or shape; every frame up to the next keyframe fails then, and
  /// `depth` and `states` mean nothing.
  Result<void> decode(const PlanarDepth& planes, DepthImage& depth, StateImage& states);

 private:
  struct Parts;
  explicit Decoder(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace copresence::depth
