#pragma once

// What there is to know of a recording: for people as a table, for programs as JSON.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_repair.h"
#include "common/result.h"

namespace copresence::record {

struct StreamInfo {
  /// Frames that are farther apart than one and a half of the usual period.
  struct Pause {
    std::size_t after_frame = 0;  ///< counted from 1
    double at_s = 0;              ///< after the stream's first frame
    double ms = 0;
  };

  recording::RecordedStream::Kind kind{};
  std::string name, codec;
  int width = 0, height = 0;
  std::size_t frames = 0;
  std::uint64_t frames_missing = 0;  ///< by their numbers
  double nominal_fps = 0, fps = 0;   ///< by the mean time between frames
  double seconds = 0;                ///< from the first frame to one period after the last
  double mbps = 0;
  std::vector<Pause> pauses;
  std::size_t without_time = 0;  ///< frames with the time of the one before, or an earlier one
};

/// What the depth pictures themselves say.
struct DepthInfo {
  double unit_mm = 1;
  double holes_percent = 0;
  std::size_t levels = 0;  ///< distinct depths
  double nearest_m = 0, farthest_m = 0;
  std::size_t damaged = 0;  ///< frames that do not decode
};

struct RecordingInfo {
  std::string file;
  std::uint64_t bytes = 0;
  bool finished = false;
  double seconds = 0;
  std::vector<StreamInfo> streams;
  std::optional<DepthInfo> depth;  ///< nothing where its codec is only OpenNI2's
  std::optional<double>
      color_after_depth_ms;  ///< median distance of a depth frame to the nearest colour frame
  std::optional<recording::CameraNote> camera;
  /// When its first frame was taken, microseconds since 1970 (UTC), where the recorder noted it.
  std::optional<std::int64_t> started_unix_us;
};

/// Reads the whole file. Fails as OniReader::open().
Result<RecordingInfo> look_into(const std::string& path, const recording::ProgressReport& progress);

std::string to_table(const RecordingInfo& info);
std::string to_json(const RecordingInfo& info);

}  // namespace copresence::record
