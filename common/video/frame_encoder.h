#pragma once

// Encodes frames to H.264: the depth picture with its side data (side_data.h), and the colour
// picture of the same instant. Each call encodes one frame. Thread: one thread at a time; different
// encoders are independent.

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
  /// Fails with kInvalid for settings out of range, with kUnsupported if libx264 does not open.
  static Result<FrameEncoder> open(const StreamDescription& stream, const VideoSettings& settings);

  /// Encodes a keyframe exactly if frame.depth.keyframe is set. Durations are copied; the caller
  /// adds its own. Requires a depth picture of the stream's format and size, or residuals and no
  /// picture. Requires a keyframe at the beginning, after a failure, and at a change between
  /// pictures and residuals. Sequence numbers start at 1 and rise.
  Result<EncodedFrame> encode(const PlanarFrame& frame);

  /// Encodes the colour of the next frame before encode() is called, so that colour need not wait
  /// for depth. If depth later forces a keyframe, encode() encodes colour again. If the frame is
  /// dropped, the next frame must be a keyframe. Thread: any thread, while no other call uses this
  /// encoder.
  void encode_color_ahead(std::uint64_t sequence, const Picture& color, bool keyframe);

  /// Changes rates or QP from the next frame on. The preset must stay the same. Returns true if the
  /// next frame must be a keyframe: after a change of the QP, or a switch between QP and bit rate.
  /// A new bit rate alone needs no keyframe. Fails as open() does, and then changes nothing.
  Result<bool> change(const VideoSettings& settings);

 private:
  FrameEncoder(const VideoSettings& settings, PictureEncoder depth,
               std::optional<DepthRateController> rate_controller, std::optional<PictureEncoder> color);

  using AccessUnit = std::vector<std::uint8_t>;
  Result<AccessUnit> encode_depth(const PlanarDepth& depth);

  VideoSettings settings_;
  PictureEncoder depth_;
  std::optional<bitstream::BlankPictureWriter> blank_;  // Used instead of depth_ for blank pictures.
  std::optional<DepthRateController> rate_controller_;
  std::optional<PictureEncoder> color_;
  struct Ahead {
    std::uint64_t sequence;
    bool is_keyframe;
    Result<AccessUnit> color;
  };
  std::optional<Ahead> color_ahead_;
  std::uint64_t previous_ = 0;  // Sequence of the last frame; 0 before the first frame.
  std::optional<Rigid3> previous_pose_;
  bool color_keyframe_needed_ = true;  // True until the first colour picture after a keyframe.
};

}  // namespace copresence::video
