#pragma once

// Describes a recording: a table for people, JSON for programs.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_repair.h"
#include "common/result.h"

namespace copresence::record {

struct StreamInfo {
  /// A gap of more than 1.5 times the usual period between two frames.
  struct Pause {
    std::size_t after_frame = 0;  ///< Number of the frame before the pause, from 1.
    double at_s = 0;              ///< Time after the first frame of the stream, seconds.
    double ms = 0;
  };

  recording::RecordedStream::Kind kind{};
  std::string name, codec;
  int width = 0, height = 0;
  std::size_t frames = 0;
  std::uint64_t frames_missing = 0;  ///< Missing frames according to the frame numbers.
  double nominal_fps = 0, fps = 0;   ///< `fps` is computed from the mean time between frames.
  double seconds = 0;                ///< From the first frame to one period after the last one.
  double mbps = 0;
  std::vector<Pause> pauses;
  /// Number of frames whose time is not later than that of the frame before.
  std::size_t without_time = 0;
};

struct DepthInfo {
  double unit_mm = 1;
  double holes_percent = 0;
  std::size_t levels = 0;  ///< Number of distinct depth values.
  double nearest_m = 0, farthest_m = 0;
  std::size_t damaged = 0;  ///< Number of frames that cannot be decoded.
};

struct RecordingInfo {
  std::string file;
  std::uint64_t bytes = 0;
  bool finished = false;
  double seconds = 0;
  std::vector<StreamInfo> streams;
  std::optional<DepthInfo> depth;  ///< Empty if no depth frame can be decoded.
  /// Median time from a depth frame to the nearest colour frame.
  std::optional<double> color_after_depth_ms;
  std::optional<recording::CameraMetadata> camera;
  /// Capture time of the first frame in microseconds since 1970 (UTC), if the recorder stored it.
  std::optional<std::int64_t> started_unix_us;
};

/// Reads the whole file. Fails as OniReader::open() does.
Result<RecordingInfo> read_info(const std::string& path, const recording::ProgressReport& progress);

std::string to_table(const RecordingInfo& info);
std::string to_json(const RecordingInfo& info);

}  // namespace copresence::record
