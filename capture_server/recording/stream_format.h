#pragma once

// What the properties of a recording's stream say about its frames, and whether OpenNI2's player and this
// project can do something with it. Part of the recording's check.
//
// Thread: a value.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_format.h"

namespace copresence::recording {

struct StreamFormat {
  std::uint32_t width = 0, height = 0, frames_per_second = 0;
  std::uint64_t pixel_format = 0;  ///< OpenNI2's number; 0 = unsaid
  std::uint64_t frame_buffer = 0;  ///< bytes that the player sets aside for a frame; 0 = unsaid
  bool has_max_depth = false;
  bool has_cropping = false;
  bool cropped = false;
  std::optional<RecordedStream::FieldOfView> field_of_view;

  /// Takes over one property as the player would; those that say nothing about the frames are skipped.
  /// Returns false where the property makes no sense, or would make none to the player.
  bool apply(RecordedStream::Kind kind, RecordType type, std::string_view key,
             std::span<const std::uint8_t> value);

  /// Fills `stream` with what is known once all its properties have been seen. `stream` has its kind and codec.
  /// Fails  kCorrupt, kUnsupported: a phrase that begins with the stream's name, for a sentence about the file.
  Result<void> describe(RecordedStream& stream) const;

  /// The most bytes that a frame of this format can take in the file; of codec NONE exactly what it takes.
  /// Requires that describe() succeeded.
  std::uint64_t max_payload(std::string_view codec, RecordedStream::Kind kind) const;

  friend bool operator==(const StreamFormat&, const StreamFormat&) = default;

 private:
  std::uint64_t bytes_per_pixel(RecordedStream::Kind kind) const;
};

/// Whether both angles can be those of a camera.
bool is_sane(const RecordedStream::FieldOfView& view);

/// "depth", "colour", "infrared".
std::string_view name(RecordedStream::Kind kind);

}  // namespace copresence::recording
