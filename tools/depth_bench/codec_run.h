#pragma once

// A depth codec over a whole recording, through the same encoders and decoders as the running system.

#include <optional>
#include <string>

#include "common/frame/picture.h"
#include "common/video/video_settings.h"
#include "tools/depth_bench/depth_recording.h"
#include "tools/depth_bench/row.h"

namespace copresence::depth_bench {

struct Setting {
  std::optional<int> qp, kbps;  ///< exactly one
  video::Preset preset = video::Preset::kLive;
  std::string text() const;  ///< qp=12 or kbps=1000
};

/// The middle frame, for pictures.
struct Snapshot {
  Picture before, after;  ///< video coding
  DepthImage depth, back;
};

/// Fails as the encoders and decoders do; a decoded frame that is not whole is an error too.
Result<Row> run_codec(const DepthRecording& recording, const std::string& codec, const Setting& setting,
                      Snapshot* snapshot = nullptr);

}  // namespace copresence::depth_bench
