#pragma once

// Reads the record chain of an .oni recording before OpenNI2 does, so that OpenNI2 never sees a file it would
// crash or stall on. OpenNI2's player trusts every number in a file; this check trusts none: sizes are
// compared with what is there before they are used, and memory stays in proportion to the number of frames.
//
// What is refused: a broken or unfinished record chain, nodes and properties that the player cannot play,
// streams this project cannot use. What is not: damage inside the frames' payloads. There is no checksum in
// the format; such a frame is lost or altered, the others are exact.
//
// Thread: free functions; concurrent calls are safe.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture_server/recording/camera_note.h"
#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::recording {

/// One stream of a recording, as its node and its frames' records describe it.
struct RecordedStream {
  enum class Kind { kDepth, kColor, kInfrared };

  /// Radians.
  struct FieldOfView {
    double horizontal = 0;
    double vertical = 0;
    friend bool operator==(const FieldOfView&, const FieldOfView&) = default;
  };

  /// Where a frame's coded picture lies in the file.
  struct Payload {
    std::uint64_t position = 0;
    std::uint32_t bytes = 0;
    friend bool operator==(const Payload&, const Payload&) = default;
  };

  Kind kind = Kind::kDepth;
  std::string name;   ///< the node's, in the recorder's words
  std::string codec;  ///< four characters: NONE, 16zT, JPEG, ...
  int width = 0;      ///< pixels; even
  int height = 0;
  int frames_per_second = 0;                 ///< nominal
  DepthUnit unit = DepthUnit::kMillimetre;   ///< depth only
  std::optional<FieldOfView> field_of_view;  ///< depth, and colour where the recorder knew it
  std::vector<std::uint64_t> timestamps_us;  ///< of every frame in the file's order, from the recorder's zero
  std::vector<Payload> payloads;             ///< of the same frames
  std::uint32_t last_frame = 0;              ///< number of the last one; frames() where none is missing

  std::size_t frames() const { return timestamps_us.size(); }
};

struct RecordingSummary {
  std::vector<RecordedStream> streams;    ///< at most one of each kind
  std::optional<CameraNote> camera_note;  ///< where there is one; of the depth stream's size and unit
  /// Microseconds from 1970 (UTC) to time zero of the timestamps, where the recorder noted it.
  std::optional<std::int64_t> unix_zero_us;
  std::chrono::microseconds duration{};  ///< of the depth stream, first frame to one period after the last

  const RecordedStream* find(RecordedStream::Kind kind) const;
};

/// Usual time between frames, microseconds: the median of the steps between their times. The nominal rate's where there
/// are fewer than two frames, and where the times say nothing: many stand still or go back, or they are closer together
/// than kFastestRate allows.
double usual_period_us(const RecordedStream& stream);

/// How many frames have the time of the one before, or an earlier one.
std::size_t steps_without_time(const RecordedStream& stream);

/// Whether a depth stream's frames come at a rate that a recording can be played at. `name` stands for the recording.
/// Fails  kUnsupported: its frames are too far apart.
Result<void> check_playable(const RecordedStream& depth, std::string_view name);

/// Walks the record chain of the file at `path`; frames' payloads are skipped, not read.
/// Fails  kNotFound (no such file, not readable), kCorrupt (not a recording, cut off, damaged: where), kUnsupported
///        (a recording, but without depth, cropped, of odd size, or in a format that nothing here decodes).
Result<RecordingSummary> check(const std::string& path);

/// What every writer asks of a file before it calls it done: check() and check_playable(). Only for what is a file:
/// what was written into a device or a pipe passes.
Result<void> check_written(const std::string& path);

/// The same as check(path) on bytes in memory; `name` stands for the path in sentences.
Result<RecordingSummary> check(std::span<const std::uint8_t> bytes, std::string_view name);

}  // namespace copresence::recording
