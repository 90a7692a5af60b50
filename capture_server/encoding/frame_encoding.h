#pragma once

// The server's half of a frame's way, in one line: registration, hole filling, depth encode, colour planes,
// video encode. The client's half is render_client/decoding/frame_decoding.h.
//
// Thread: one thread encodes; depth rate and keyframes are asked for by the same thread.

#include <memory>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/registration/registration.h"
#include "capture_server/sensor/frame_source.h"
#include "capture_server/settings.h"
#include "common/depth/depth_codec.h"
#include "common/executor.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/scene/scene.h"
#include "common/video/frame_encoder.h"

namespace copresence::server {

/// Depth outside `range` becomes a hole, so that neither filling nor coding takes it for a surface. Thread: pure.
void clip_to_range(RgbdFrame& frame, const DepthRangeUnits& range);

class FrameEncoding {
 public:
  /// `camera`: what the scene file says of this camera; nullptr where nothing is known. Fails on sizes,
  /// ranges and codecs that do not go together, with a sentence for the person who started the server.
  static Result<FrameEncoding> open(const sensor::SensorDescription& sensor, const scene::Camera* camera,
                                    const ServerSettings& settings);

  const StreamDescription& description() const { return description_; }

  /// From the next frame on, which is a keyframe where depth gets another quantiser, or a rate instead of one. Fails where libx264
  /// refuses; everything is then as before.
  Result<void> set_rates(const EncoderSettings& rates);

  /// One frame in, one out. `keyframe`: this one must need nothing of earlier frames. With `workers` colour is
  /// encoded beside the filling and coding of depth.
  Result<EncodedFrame> encode(RgbdFrame frame, bool keyframe, Executor* workers = nullptr);

 private:
  FrameEncoding(StreamDescription description, registration::Registration registration,
                std::unique_ptr<hole_filling::HoleFiller> filler, depth::Encoder depth,
                video::FrameEncoder video);

  StreamDescription description_;
  registration::Registration registration_;
  std::unique_ptr<hole_filling::HoleFiller> filler_;
  depth::Encoder depth_;
  video::FrameEncoder video_;
  bool keyframe_due_ = false;
};

}  // namespace copresence::server
