// Properties of the side data in an access unit for random bytes (RapidCheck).

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/bitstream/side_data.h"
#include "common/frame/bounds.h"

namespace copresence::video {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Bytes that often form start codes and need emulation prevention.
Bytes any_bytes() {
  return *rc::gen::container<Bytes>(rc::gen::oneOf(rc::gen::element<std::uint8_t>(0, 0, 0, 1, 2, 3, 4),
                                                   rc::gen::arbitrary<std::uint8_t>()));
}

RC_GTEST_PROP(VideoLaws, NoStartCodeShowsInANalUnitAndItsPayloadComesBack, ()) {
  const Bytes payload = any_bytes();
  const Bytes nal = bitstream::to_nal_bytes(payload);
  RC_ASSERT(bitstream::from_nal_bytes(nal) == payload);
  for (std::size_t i = 0; i + 2 < nal.size(); ++i)
    RC_ASSERT(nal[i] != 0 || nal[i + 1] != 0 || nal[i + 2] > 2);
}

RC_GTEST_PROP(VideoLaws, SideDataComesBackAsItWasWhateverItIs, ()) {
  bitstream::SideData data;
  data.sequence = *rc::gen::arbitrary<std::uint64_t>();
  data.previous = *rc::gen::arbitrary<std::uint64_t>();
  const auto captured_ns = *rc::gen::arbitrary<std::int64_t>();
  data.captured_at = Instant(std::chrono::nanoseconds(captured_ns));
  data.qp = *rc::gen::arbitrary<std::uint8_t>();
  data.has_color = *rc::gen::arbitrary<bool>();
  if (*rc::gen::arbitrary<bool>()) data.world_from_camera = Rigid3{};
  data.table = any_bytes();
  data.residuals = any_bytes();
  data.validity_mask = any_bytes();
  const Bytes picture = {0, 0, 0, 1, 0x65, 0x33, 0x44};
  const Bytes color = data.has_color ? Bytes{0, 0, 0, 1, 0x61, 0x55} : Bytes{};
  const Bytes unit = bitstream::add_side_data(picture, color, data);
  const auto back = bitstream::extract_side_data(unit, color);
  const bool within_bounds = is_within_bounds(data.sequence) && is_within_bounds(data.previous) &&
                             is_within_bounds(static_cast<std::uint64_t>(captured_ns));
  RC_ASSERT(back.has_value() == within_bounds);
  if (back) RC_ASSERT(*back == data);
  Bytes damaged = unit;
  damaged[*rc::gen::inRange<std::size_t>(0, unit.size())] ^= *rc::gen::inRange<std::uint8_t>(1, 255);
  RC_ASSERT(!bitstream::extract_side_data(damaged, color).has_value());
}

}  // namespace
}  // namespace copresence::video
