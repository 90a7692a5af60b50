#pragma once

// The settings of the encoding module.

#include <optional>
#include <string>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/temporal_filter/temporal_filter.h"
#include "common/frame/depth_unit.h"

namespace copresence::server {

/// Quality and bitrates. All of these settings can change while the server runs.
struct EncoderSettings {
  int depth_qp = 20;              ///< 0 (lossless) to 51.
  std::optional<int> depth_kbps;  ///< Bitrate of depth with all its side data. The bitrate replaces depth_qp.
  int color_kbps = 2500;

  bool is_lossless() const { return depth_qp == 0 && !depth_kbps; }
  friend bool operator==(const EncoderSettings&, const EncoderSettings&) = default;
};

/// Settings that stay the same for the whole stream, and the encoder settings that it starts with.
struct EncodingSettings {
  std::string name;  ///< The camera's name.
  std::string codec = "adaptive";
  EncoderSettings encoder;
  hole_filling::Method hole_filling = hole_filling::Method::kJoint;
  hole_filling::Compute compute = hole_filling::Compute::kAuto;
  temporal_filter::Mode temporal_filter = temporal_filter::Mode::kAuto;
  DepthRange range;
};

}  // namespace copresence::server
