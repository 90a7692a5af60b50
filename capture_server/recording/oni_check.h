#pragma once

// Checks the record chain of an .oni recording. OpenNI2's player trusts every number in a file;
// this check trusts none. Sizes are compared with the file's size before they are used, and memory
// is proportional to the number of frames.
//
// Rejected are a broken or unfinished record chain, streams that this project cannot use, and nodes
// and properties that OpenNI2 cannot play. Not checked are the frames' payloads: the format has no
// checksum. A frame with a damaged payload is lost or altered; the others are exact.
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

/// One stream of a recording, from its node and its frames' records.
struct RecordedStream {
  enum class Kind { kDepth, kColor, kInfrared };

  /// Radians.
  struct FieldOfView {
    double horizontal = 0;
    double vertical = 0;
    friend bool operator==(const FieldOfView&, const FieldOfView&) = default;
  };

  /// Position of a frame's coded picture in the file.
  struct Payload {
    std::uint64_t position = 0;
    std::uint32_t bytes = 0;
    friend bool operator==(const Payload&, const Payload&) = default;
  };

  Kind kind = Kind::kDepth;
  std::string name;   ///< of the node, chosen by the recorder
  std::string codec;  ///< four characters: NONE, 16zT, JPEG, ...
  int width = 0;      ///< pixels; even
  int height = 0;
  int frames_per_second = 0;                 ///< nominal
  DepthUnit unit = DepthUnit::kMillimetre;   ///< depth only
  std::optional<FieldOfView> field_of_view;  ///< depth, and colour if the recorder knew it
  std::vector<std::uint16_t>
      levels;  ///< depth only: all that its sensor can report, ascending; empty if not recorded
  std::vector<std::uint64_t>
      timestamps_us;              ///< of all frames in the file's order, from the recorder's time zero
  std::vector<Payload> payloads;  ///< of the same frames
  std::uint32_t last_frame = 0;   ///< number of the last frame; frames() if none is missing

  std::size_t frames() const { return timestamps_us.size(); }
};

struct RecordingSummary {
  std::vector<RecordedStream> streams;            ///< at most one of each kind
  std::optional<CameraMetadata> camera_metadata;  ///< if present; of the depth stream's size and unit
  /// Microseconds from 1970 (UTC) to time zero of the timestamps, if the recorder noted it.
  std::optional<std::int64_t> unix_zero_us;
  std::chrono::microseconds
      duration{};  ///< of the depth stream: from its first frame to one period after the last

  const RecordedStream* find(RecordedStream::Kind kind) const;
};

/// Usual time between frames in microseconds: the median of the steps between their times. It is
/// the nominal period if there are fewer than two frames or if the times are unusable: many stand
/// still or decrease, or they are closer together than kFastestRate allows.
double usual_period_us(const RecordedStream& stream);

/// Number of frames whose time is not later than that of the frame before.
std::size_t steps_without_time(const RecordedStream& stream);

/// Checks that a depth stream's frame rate can be played. `name` is the recording's name in
/// messages.
/// Fails  kUnsupported: its frames are too far apart.
Result<void> check_playable(const RecordedStream& depth, std::string_view name);

/// Parses the record chain of the file at `path`; frames' payloads are skipped.
/// Fails  kNotFound (no such file, not readable), kCorrupt (not a recording, cut off, damaged; with
///        the place), kUnsupported (without depth, cropped, of odd size, or in an unknown format).
Result<RecordingSummary> check(const std::string& path);

/// check() and check_playable() of a file that was just written; every writer calls it at the end.
/// Devices and pipes pass without a check.
Result<void> check_written(const std::string& path);

/// The same as check(path) on bytes in memory; `name` replaces the path in messages.
Result<RecordingSummary> check(std::span<const std::uint8_t> bytes, std::string_view name);

}  // namespace copresence::recording
