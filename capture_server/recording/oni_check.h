#pragma once

// Checks the record chain of an .oni recording. OpenNI2's player trusts every number in a file, but
// this check trusts none. The check compares sizes with the file's size before it uses them. The
// check's memory is proportional to the number of frames.
//
// The check rejects broken or unfinished record chains, streams that this project cannot use, and
// nodes and properties that OpenNI2 cannot play. The frames' payloads are not checked, because the
// format has no checksum. A frame with a damaged payload is lost or altered; the others are exact.
//
// Thread: free functions; concurrent calls are safe.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture_server/recording/camera_metadata.h"
#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::recording {

/// One stream of a recording, from the records of its node and its frames.
struct RecordedStream {
  enum class Kind { kDepth, kColor, kInfrared };

  /// The angles that a camera covers, in radians.
  struct FieldOfView {
    double horizontal = 0;
    double vertical = 0;
    friend bool operator==(const FieldOfView&, const FieldOfView&) = default;
  };

  struct Payload {
    std::uint64_t position = 0;
    std::uint32_t bytes = 0;
    friend bool operator==(const Payload&, const Payload&) = default;
  };

  Kind kind = Kind::kDepth;
  std::string name;   ///< Name of the node, chosen by the recorder.
  std::string codec;  ///< Four characters, such as NONE, 16zT or JPEG.
  int width = 0;      ///< In pixels; even.
  int height = 0;
  int frames_per_second = 0;                ///< Nominal frame rate.
  DepthUnit unit = DepthUnit::kMillimetre;  ///< Unit of depth. Unused for other streams.
  /// Field of view of depth. For colour, the field of view is set only if the recorder knew it.
  std::optional<FieldOfView> field_of_view;
  /// All depths that the sensor can report, in ascending order. The list is empty if unknown.
  std::vector<std::uint16_t> levels;
  /// Times of all frames in the file's order, counted from the recorder's time zero.
  std::vector<std::uint64_t> timestamps_us;
  std::vector<Payload> payloads;  ///< Payloads of the frames, in the same order.
  /// Number of the last frame. The number equals frames() if no frame is missing.
  std::uint32_t last_frame = 0;

  std::size_t frames() const { return timestamps_us.size(); }
};

struct RecordingSummary {
  std::vector<RecordedStream> streams;            ///< At most one stream of each kind.
  std::optional<CameraMetadata> camera_metadata;  ///< Nothing if the recording has no metadata.
  /// Microseconds from 1970 (UTC) to time zero of the timestamps, if the recorder stored it.
  std::optional<std::int64_t> unix_zero_us;
  /// Duration of the depth stream, from its first frame to one period after the last.
  std::chrono::microseconds duration{};

  const RecordedStream* find(RecordedStream::Kind kind) const;
};

/// Usual time between frames in microseconds: the median of the steps between their times. The
/// result is the nominal period if the stream has fewer than two frames or unusable times. Times
/// are unusable if many do not increase or if they are closer together than kFastestRate allows.
double usual_period_us(const RecordedStream& stream);

/// Number of frames that are not later than the previous frame.
std::size_t steps_without_time(const RecordedStream& stream);

/// Checks that a depth stream can be played. `name` is the recording's name in messages.
/// Fails with kUnsupported if its frames are too far apart.
Result<void> check_playable(const RecordedStream& depth, std::string_view name);

/// Parses the record chain of the file at `path`. Frames' payloads are skipped.
/// Fails with kNotFound if the file does not exist or cannot be read. Fails with kCorrupt if the
/// file is not a recording, is cut off or is damaged; the message names the place. Fails with
/// kUnsupported without depth, or if a stream is cropped, of odd size or in an unknown format.
Result<RecordingSummary> check(const std::string& path);

/// Runs check() and check_playable() on a file that was just written. Every writer calls this
/// function at the end. Devices and pipes pass without a check.
Result<void> check_written(const std::string& path);

/// Parses bytes in memory as check(path) does. `name` replaces the path in messages.
Result<RecordingSummary> check(std::span<const std::uint8_t> bytes, std::string_view name);

}  // namespace copresence::recording
