#pragma once

// One coded picture as bytes: an H.264 access unit in Annex B form, and the NAL units in it.
// Source: ITU-T H.264 (08/2021), sections 7.3.1, 7.4.1.2 and annex B.
// Thread: pure.

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"

namespace copresence::bitstream {

enum class NalType : std::uint8_t {
  kSlice = 1,
  kIdrSlice = 5,
  kSei = 6,
  kSequenceParameters = 7,
  kPictureParameters = 8
};

/// One NAL unit: its bytes without start code and trailing zeros, never empty.
struct Nal {
  std::span<const std::uint8_t> bytes;

  NalType type() const { return static_cast<NalType>(bytes[0] & 31); }
  /// Whether the picture depends on it: slices and parameter sets. A stream copy keeps these as they are; it
  /// may add, move or drop the others (delimiters, fillers, SEI).
  bool is_essential() const;
};

/// The NAL units in the order of the bytes, which must outlive them.
/// Fails with kCorrupt when the bytes do not begin with a start code or a NAL unit is empty or forbidden.
Result<std::vector<Nal>> split_access_unit(std::span<const std::uint8_t> access_unit);

/// Appends a start code and the NAL unit.
void append_nal(std::vector<std::uint8_t>& access_unit, std::span<const std::uint8_t> nal);

/// Puts emulation prevention bytes into a payload so that no start code shows in it, and takes them out
/// again.
std::vector<std::uint8_t> to_nal_bytes(std::span<const std::uint8_t> payload);
std::vector<std::uint8_t> from_nal_bytes(std::span<const std::uint8_t> nal);

}  // namespace copresence::bitstream
