#pragma once

// Encodes a frame on the server: registration, hole filling, temporal filter, depth encoding,
// colour conversion, video encoding. The client's counterpart is
// render_client/decoding/frame_decoding.h.
//
// Thread: one thread at a time.

#include <memory>
#include <optional>

#include "capture_server/encoding/encoder_settings.h"
#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/registration/registration.h"
#include "capture_server/sensor/frame_source.h"
#include "capture_server/temporal_filter/color_filter.h"
#include "capture_server/temporal_filter/depth_filter.h"
#include "common/depth/depth_codec.h"
#include "common/executor.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "common/scene/scene.h"
#include "common/video/frame_encoder.h"

namespace copresence::server {

/// Turns depth outside `range` into holes, so that it is neither filled nor encoded.
void clip_to_range(RgbdFrame& frame, const DepthRangeUnits& range);

class FrameEncoding {
 public:
  /// `camera` is this camera's entry in the scene file, or nullptr. Intrinsics and pose of that
  /// entry replace the sensor's.
  /// Fails with a sentence for the user if sizes, range and codec do not fit together.
  static Result<FrameEncoding> open(const sensor::SensorDescription& sensor, const scene::Camera* camera,
                                    const EncodingSettings& settings);

  const StreamDescription& description() const { return description_; }

  /// Changes the settings from the next frame on. Changing the depth QP, or switching between QP
  /// and bitrate, forces a keyframe. Lossless frames are not filtered over time.
  /// Fails if libx264 rejects the new settings; the old settings then stay in force.
  Result<void> change_settings(const EncoderSettings& settings);

  /// Encodes one frame. If `keyframe` is true, the coded frame does not depend on earlier ones.
  /// With `workers`, colour is encoded in parallel to the filling and coding of depth.
  Result<EncodedFrame> encode(RgbdFrame frame, bool keyframe, Executor* workers = nullptr);

 private:
  struct TemporalFilters {
    temporal_filter::DepthFilter depth;
    temporal_filter::ColorFilter color;
  };

  FrameEncoding(StreamDescription description, registration::Registration registration,
                std::unique_ptr<hole_filling::HoleFiller> filler, depth::Encoder depth,
                video::FrameEncoder video, temporal_filter::Mode temporal_filter);

  void choose_filters(const EncoderSettings& settings);

  StreamDescription description_;
  registration::Registration registration_;
  std::unique_ptr<hole_filling::HoleFiller> filler_;
  temporal_filter::Mode temporal_filter_;
  std::optional<TemporalFilters> filters_;  ///< Empty while frames are not filtered.
  depth::Encoder depth_;
  video::FrameEncoder video_;
  bool keyframe_due_ = false;
};

}  // namespace copresence::server
