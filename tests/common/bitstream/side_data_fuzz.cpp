// Side data with a correct checksum, as a malicious server may write it. The input is everything
// after the checksum. All accepted numbers must be within the bounds that the rest of the program
// relies on.

#include "common/bitstream/side_data.h"

#include <zlib.h>

#include <cstdlib>
#include <span>

#include "common/frame/bounds.h"

namespace copresence::bitstream {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kUuid[] = {0x5c, 0x1e, 0x37, 0xa0, 0x2f, 0x6b, 0x4d, 0x58,
                                  0x9e, 0x43, 0xc0, 0x97, 0xe5, 0x1d, 0x80, 0x6a};
const Bytes kSlice = {0x65, 0x33, 0x44};

/// The layout of docs/internals/sei.md.
Bytes access_unit_with(std::span<const std::uint8_t> checked) {
  const auto of_checked = crc32_z(0, checked.data(), checked.size());
  const auto crc = static_cast<std::uint32_t>(crc32_z(of_checked, kSlice.data(), kSlice.size()));
  Bytes payload(std::begin(kUuid), std::end(kUuid));
  for (int i = 0; i < 4; ++i) payload.push_back(static_cast<std::uint8_t>(crc >> 8 * i));
  payload.insert(payload.end(), checked.begin(), checked.end());
  Bytes sei = {6, 5};
  std::size_t size = payload.size();
  for (; size >= 255; size -= 255) sei.push_back(255);
  sei.push_back(static_cast<std::uint8_t>(size));
  sei.insert(sei.end(), payload.begin(), payload.end());
  sei.push_back(0x80);
  Bytes unit;
  append_nal(unit, to_nal_bytes(sei));
  append_nal(unit, kSlice);
  return unit;
}

}  // namespace
}  // namespace copresence::bitstream

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace copresence;
  const auto extracted = bitstream::extract_side_data(bitstream::access_unit_with(std::span(data, size)), {});
  if (!extracted) return 0;
  const bool sound = extracted->captured_at >= Instant{} &&
                     extracted->captured_at < Instant(std::chrono::nanoseconds(kNumberBound)) &&
                     is_within_bounds(extracted->sequence) && is_within_bounds(extracted->previous) &&
                     (!extracted->world_from_camera || check_pose(*extracted->world_from_camera));
  if (!sound) std::abort();
  return 0;
}
