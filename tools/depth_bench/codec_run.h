#pragma once

// Runs a depth codec on a recording, with the encoders of the server and decoders of the client.

#include <optional>
#include <string>
#include <vector>

#include "common/frame/picture.h"
#include "common/video/video_settings.h"
#include "tools/depth_bench/depth_recording.h"
#include "tools/depth_bench/row.h"
#include "tools/progress/progress.h"

namespace copresence::depth_bench {

struct Setting {
  std::optional<int> qp, kbps;  ///< Exactly one of the two is set.
  video::Preset preset = video::Preset::kLive;
  std::string text() const;  ///< Such as "qp=12" or "kbps=1000".
};

/// The middle frame of a recording, for plots.
struct Snapshot {
  Picture before, after;  ///< The depth picture before and after video coding.
  DepthImage depth, back;
};

/// Codes and decodes all frames. Fails if an encoder or decoder fails.
Result<Row> run_codec(const DepthRecording& recording, const std::string& codec, const Setting& setting,
                      Snapshot* snapshot = nullptr);

/// Codecs that tune() tries: all codecs, some of them also with other parameters.
std::vector<std::string> tuning_candidates();

/// Runs all candidates at a bitrate and sorts them by RMSE in disparity steps, the best first
/// (thesis 5.1.2). Codecs more than a tenth above the bitrate come last. Fails as run_codec() does.
Result<std::vector<Row>> tune(const DepthRecording& recording, int kbps, video::Preset preset,
                              tools::Progress& progress);

}  // namespace copresence::depth_bench
