#pragma once

// What must arrive exactly, inside the depth access unit: stamp, state mask, level table and samples, as one SEI
// message of type user_data_unregistered with a UUID of our own, so that any copy of the stream (wire,
// Matroska, MPEG-TS, a relay) keeps them with their picture. A CRC over them and over both coded pictures
// makes damage, loss of a part and a wrong pair of pictures an error. The layout is drawn byte by byte in
// docs/internals/sei.md and held by SideData.HasTheDocumentedBytes. Thread: pure.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/bitstream/access_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/rigid3.h"
#include "common/result.h"

namespace copresence::bitstream {

struct SideData {
  std::uint64_t sequence = 0;
  std::uint64_t previous = 0;  ///< sequence of the frame this one builds on; 0: on none, it is a keyframe
  Instant captured_at{};       ///< on the capture process's monotonic clock, at or after its zero
  std::uint8_t qp = 0;         ///< of the depth picture; 0: lossless
  bool has_color = false;      ///< a colour access unit belongs to this frame
  std::optional<Rigid3> world_from_camera;  ///< nothing: as in the frame before
  std::vector<std::uint8_t> table;
  std::vector<std::uint8_t> residuals;  ///< depth coded without loss; the picture is blank then
  std::vector<std::uint8_t> validity_mask;

  friend bool operator==(const SideData&, const SideData&) = default;
};

/// About what the side data adds to the access unit: emulation prevention bytes are not counted.
std::size_t side_data_bytes(const SideData& data);

/// The access unit with its essential NAL units and, before its first slice, the side data. `color` is the
/// frame's colour access unit, empty where there is none. Requires access units as a PictureEncoder makes
/// them, data.has_color == !color.empty().
std::vector<std::uint8_t> add_side_data(std::span<const std::uint8_t> depth,
                                        std::span<const std::uint8_t> color, const SideData& data);

/// The inverse.
/// Fails with kCorrupt when anything that matters is not as it was: side data, a slice, a parameter set, of
/// either picture.
Result<SideData> extract_side_data(std::span<const std::uint8_t> depth, std::span<const std::uint8_t> color);

}  // namespace copresence::bitstream
