#pragma once

// Reads the side data of a stream's frames before their pictures are decoded. It checks that no
// frame is missing: a video decoder would hide a missing frame and show a wrong picture.
//
// The module knows no video decoder. common/video decodes the pictures with FFmpeg, and web/ lets
// the browser do it. Thread: distinct objects are independent.

#include <cstdint>
#include <optional>

#include "common/frame/coded_frame.h"
#include "common/frame/rigid3.h"
#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::bitstream {

class FrameChain {
 public:
  explicit FrameChain(const StreamDescription& stream);

  /// Returns the next frame without its pictures: metadata, side data and durations. Its keyframe
  /// flag and sequence come from the access unit. Fails as extract_side_data() does. Also fails with
  /// kCorrupt if a frame is missing before this one, or if it has colour although the stream has
  /// none. After a failure only a keyframe is accepted.
  Result<PlanarFrame> next(const EncodedFrame& encoded);

  /// Accepts only a keyframe next. Call it if a picture of the last frame does not decode.
  void await_keyframe() { previous_.reset(); }

 private:
  Result<PlanarFrame> next_checked(const EncodedFrame& encoded);

  bool has_color_;
  Rigid3 world_from_camera_;
  std::optional<std::uint64_t> previous_;  // Sequence of the last frame; empty if a keyframe is needed.
};

}  // namespace copresence::bitstream
