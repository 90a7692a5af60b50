#pragma once

// Splits H.264 access units in Annex B form into NAL units, and writes them. Source: ITU-T H.264
// (08/2021), sections 7.3.1, 7.4.1.2 and annex B. Thread: pure.

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

/// One NAL unit without its start code and trailing zeros. It is never empty.
struct Nal {
  std::span<const std::uint8_t> bytes;

  NalType type() const { return static_cast<NalType>(bytes[0] & 31); }
  /// True for slices and parameter sets, without which the picture cannot be decoded. A program
  /// that copies a stream may drop or move only the other units.
  bool is_essential() const;
};

/// Returns the NAL units in order; they refer to the given bytes. Fails with kCorrupt if the bytes
/// do not begin with a start code, or if a NAL unit is empty or forbidden.
Result<std::vector<Nal>> split_access_unit(std::span<const std::uint8_t> access_unit);

/// Appends a start code and the NAL unit.
void append_nal(std::vector<std::uint8_t>& access_unit, std::span<const std::uint8_t> nal);

/// Inserts or removes emulation prevention bytes. With these bytes a payload contains no start
/// code.
std::vector<std::uint8_t> to_nal_bytes(std::span<const std::uint8_t> payload);
std::vector<std::uint8_t> from_nal_bytes(std::span<const std::uint8_t> nal);

}  // namespace copresence::bitstream
