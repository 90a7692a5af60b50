#pragma once

// The format of a stream's frames, from its properties. The class also decides whether this project
// and OpenNI2's player can use the stream. The class is part of the recording's check.
// Thread: one thread at a time per object.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_format.h"

namespace copresence::recording {

struct StreamFormat {
  std::uint32_t width = 0, height = 0, frames_per_second = 0;
  std::uint64_t pixel_format = 0;  ///< OpenNI2's number of the pixel format, or 0 if unknown.
  std::uint64_t frame_buffer = 0;  ///< Size of the player's buffer for a frame in bytes. 0 if not given.
  bool has_max_depth = false;
  bool has_cropping = false;
  bool cropped = false;
  std::optional<RecordedStream::FieldOfView> field_of_view;

  /// Applies one property as the player would. Properties that do not concern the frames are
  /// ignored. Returns false if the property is invalid for this project or the player.
  bool apply(RecordedStream::Kind kind, RecordType type, std::string_view key,
             std::span<const std::uint8_t> value);

  /// Fills in `stream` after all its properties were applied. Requires its kind and codec.
  /// Fails with kCorrupt or kUnsupported. The message is a phrase that begins with the stream's
  /// name, for a sentence about the file.
  Result<void> describe(RecordedStream& stream) const;

  /// The maximum size of a coded frame in bytes. With codec NONE the size is exact. Call describe()
  /// first.
  std::uint64_t max_payload(std::string_view codec, RecordedStream::Kind kind) const;

  friend bool operator==(const StreamFormat&, const StreamFormat&) = default;

 private:
  std::uint64_t bytes_per_pixel(RecordedStream::Kind kind) const;
};

/// True if both angles are plausible for a camera.
bool is_sane(const RecordedStream::FieldOfView& view);

/// "depth", "colour", "infrared".
std::string_view name(RecordedStream::Kind kind);

}  // namespace copresence::recording
