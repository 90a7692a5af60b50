#pragma once

// Frames to H.264: the depth picture with its side data (side_data.h) and the colour picture of the same
// instant. One frame in, one out, at once. Thread: one at a time; different encoders are independent.

#include <cstdint>
#include <optional>
#include <vector>

#include "common/bitstream/blank_picture.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/video/depth_rate_controller.h"
#include "common/video/picture_encoder.h"
#include "common/video/video_settings.h"

namespace copresence::video {

class FrameEncoder {
 public:
  /// Fails with kInvalid for settings out of range, with kUnsupported where libx264 is missing or refuses.
  static Result<FrameEncoder> open(const StreamDescription& stream, const VideoSettings& settings);

  /// A keyframe exactly where frame.depth.keyframe is set. Durations are copied; the caller adds its own.
  /// Requires pictures of the stream's format and size, or samples and no picture; a keyframe where one follows the other; a
  /// keyframe first; sequence numbers from 1 upward;
  /// after a failure, a keyframe.
  Result<EncodedFrame> encode(const PlanarFrame& frame);

  /// Encodes the colour of the frame `sequence`, the coming one, so that encode() finds it done: colour does not have
  /// to wait for depth. `keyframe` as far as it is known: where depth turns out to be one by itself, colour is encoded again. Where that
  /// frame comes to nothing, so does this.
  /// Thread: beside whatever does not use this encoder.
  void encode_color_ahead(std::uint64_t sequence, const Picture& color, bool keyframe);

  /// Other rates or another quantiser, of the same effort, from the next frame on. Where this says true that frame must be a keyframe:
  /// another quantiser, or a rate instead of one, is another H.264 stream; another rate is not.
  /// Fails as open() does, and everything is as before.
  Result<bool> change(const VideoSettings& settings);

 private:
  FrameEncoder(const VideoSettings& settings, PictureEncoder depth, std::optional<DepthRateController> budget,
               std::optional<PictureEncoder> color);

  using AccessUnit = std::vector<std::uint8_t>;
  Result<AccessUnit> encode_depth(const PlanarDepth& depth);

  VideoSettings settings_;
  PictureEncoder depth_;
  std::optional<bitstream::BlankPictureWriter> flat_;  // instead of depth_, since the last keyframe
  std::optional<DepthRateController> budget_;
  std::optional<PictureEncoder> color_;
  struct Ahead {
    std::uint64_t sequence;
    bool is_keyframe;
    Result<AccessUnit> color;
  };
  std::optional<Ahead> color_ahead_;
  std::uint64_t previous_ = 0;  // sequence of the last frame, 0 before the first
  std::optional<Rigid3> previous_pose_;
  bool color_keyframe_needed_ = true;  // set until the first colour picture after a keyframe
};

}  // namespace copresence::video
