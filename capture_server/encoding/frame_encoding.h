#pragma once

// The server's stages of a frame in order: registration, hole filling, depth encoding, colour
// conversion, video encoding. The client's stages are in render_client/decoding/frame_decoding.h.
//
// Thread: one thread at a time.

#include <memory>

#include "capture_server/encoding/encoder_settings.h"
#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/registration/registration.h"
#include "capture_server/sensor/frame_source.h"
#include "common/depth/depth_codec.h"
#include "common/executor.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/scene/scene.h"
#include "common/video/frame_encoder.h"

namespace copresence::server {

/// Turns depth outside `range` into holes, so that neither filling nor coding treats it as a
/// surface.
void clip_to_range(RgbdFrame& frame, const DepthRangeUnits& range);

class FrameEncoding {
 public:
  /// `camera`: this camera's entry in the scene file, or nullptr. Its intrinsics and pose replace
  /// the sensor's.
  /// Fails if sizes, range and codec do not fit together, with a sentence for the user.
  static Result<FrameEncoding> open(const sensor::SensorDescription& sensor, const scene::Camera* camera,
                                    const EncodingSettings& settings);

  const StreamDescription& description() const { return description_; }

  /// Takes effect at the next frame. Changing the depth QP, or switching between QP and bitrate,
  /// forces a keyframe.
  /// Fails if libx264 refuses; the settings are then as before.
  Result<void> change_settings(const EncoderSettings& settings);

  /// Encodes one frame. `keyframe`: it must not depend on earlier frames. With `workers`, colour is
  /// encoded in parallel to the filling and coding of depth.
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
