#pragma once

// Converts H.264 access units between Annex B form, in which a start code precedes each NAL unit,
// and the form of MP4 and Matroska, in which a length of four bytes precedes it. The NAL units stay
// unchanged. Source: ISO/IEC 14496-15, sections 5.3.2 and 5.3.3.1. Thread: pure functions.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/bitstream/access_unit.h"
#include "common/frame/picture.h"
#include "common/result.h"

namespace copresence::bitstream {

/// Returns the NAL units with their lengths.
std::vector<std::uint8_t> to_length_prefixed(std::span<const Nal> nals);

/// Returns the access unit in Annex B form. Fails with kCorrupt unless the lengths add up.
Result<std::vector<std::uint8_t>> from_length_prefixed(std::span<const std::uint8_t> bytes);

/// Returns the AVC configuration record, which tells players the format before the first picture.
/// Returns nothing unless the access unit has both parameter sets. `format` is that of its picture.
std::optional<std::vector<std::uint8_t>> avc_configuration(std::span<const Nal> nals, PixelFormat format);

}  // namespace copresence::bitstream
