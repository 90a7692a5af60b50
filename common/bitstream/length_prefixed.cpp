#include "common/bitstream/length_prefixed.h"

#include <algorithm>

namespace copresence::bitstream {
namespace {

constexpr std::size_t kLengthBytes = 4;

void append_big_endian(std::vector<std::uint8_t>& out, std::size_t value, std::size_t bytes) {
  for (std::size_t i = bytes; i-- > 0;) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

const Nal* find(std::span<const Nal> nals, NalType type) {
  const auto found =
      std::find_if(nals.begin(), nals.end(), [&](const Nal& nal) { return nal.type() == type; });
  return found == nals.end() ? nullptr : &*found;
}

/// Profiles whose records also state the picture's format.
bool states_format(std::uint8_t profile) {
  constexpr std::uint8_t kBaseline = 66, kMain = 77, kExtended = 88;
  return profile != kBaseline && profile != kMain && profile != kExtended;
}

}  // namespace

std::vector<std::uint8_t> to_length_prefixed(std::span<const Nal> nals) {
  std::vector<std::uint8_t> out;
  std::size_t bytes = 0;
  for (const Nal& nal : nals) bytes += kLengthBytes + nal.bytes.size();
  out.reserve(bytes);
  for (const Nal& nal : nals) {
    append_big_endian(out, nal.bytes.size(), kLengthBytes);
    out.insert(out.end(), nal.bytes.begin(), nal.bytes.end());
  }
  return out;
}

Result<std::vector<std::uint8_t>> from_length_prefixed(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> access_unit;
  access_unit.reserve(bytes.size());
  while (!bytes.empty()) {
    std::size_t length = 0;
    if (bytes.size() > kLengthBytes) {
      for (const std::uint8_t byte : bytes.first(kLengthBytes)) length = length << 8 | byte;
      bytes = bytes.subspan(kLengthBytes);
    }
    if (length == 0 || length > bytes.size())
      return fail(ErrorCode::kCorrupt, "the lengths of an access unit's NAL units do not add up");
    append_nal(access_unit, bytes.first(length));
    bytes = bytes.subspan(length);
  }
  return access_unit;
}

std::optional<std::vector<std::uint8_t>> avc_configuration(std::span<const Nal> nals, PixelFormat format) {
  const Nal* const sequence = find(nals, NalType::kSequenceParameters);
  const Nal* const picture = find(nals, NalType::kPictureParameters);
  constexpr std::size_t kMostBytes = 0xFFFF;
  if (!sequence || !picture || sequence->bytes.size() < 4 || sequence->bytes.size() > kMostBytes ||
      picture->bytes.size() > kMostBytes) {
    return std::nullopt;
  }
  const std::uint8_t profile = sequence->bytes[1];
  std::vector<std::uint8_t> out = {1, profile, sequence->bytes[2], sequence->bytes[3]};
  out.push_back(0xFC | (kLengthBytes - 1));
  out.push_back(0xE0 | 1);  // The number of sequence parameter sets.
  append_big_endian(out, sequence->bytes.size(), 2);
  out.insert(out.end(), sequence->bytes.begin(), sequence->bytes.end());
  out.push_back(1);  // The number of picture parameter sets.
  append_big_endian(out, picture->bytes.size(), 2);
  out.insert(out.end(), picture->bytes.begin(), picture->bytes.end());
  if (states_format(profile)) {
    const std::uint8_t chroma = format == PixelFormat::kYuv420 ? 1 : format == PixelFormat::kYuv444 ? 3 : 0;
    const std::uint8_t extra_bits = format == PixelFormat::kGray10 ? 2 : 0;  // Beyond 8 bits.
    out.push_back(0xFC | chroma);
    out.push_back(0xF8 | extra_bits);
    out.push_back(0xF8 | extra_bits);
    out.push_back(0);  // There are no extensions of the sequence parameter set.
  }
  return out;
}

}  // namespace copresence::bitstream
