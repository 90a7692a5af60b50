#pragma once

// Side data: the parts of a frame that must arrive exactly. Metadata, validity mask, codebook
// change and residuals are stored inside the depth access unit, as one SEI message of type
// user_data_unregistered with a UUID of our own. Any copy of the stream (wire, Matroska, MPEG-TS, a
// relay) keeps them with their picture.
//
// A CRC-32 over the side data and both coded pictures detects damage, missing parts, and pictures
// of different frames. docs/internals/sei.md describes the layout; the test
// SideData.HasTheDocumentedBytes checks it. Thread: pure.

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
  std::uint64_t previous = 0;               ///< sequence of the frame that this one needs; 0 in a keyframe
  Instant captured_at{};                    ///< on the capture process's monotonic clock; not before its zero
  std::uint8_t qp = 0;                      ///< of the depth picture; 0: lossless
  bool has_color = false;                   ///< this frame has a colour access unit
  std::optional<Rigid3> world_from_camera;  ///< if absent, as in the frame before
  std::vector<std::uint8_t> table;
  std::vector<std::uint8_t> residuals;  ///< depth coded without loss; the picture is blank then
  std::vector<std::uint8_t> validity_mask;

  friend bool operator==(const SideData&, const SideData&) = default;
};

/// Approximate size of the side data in the access unit: emulation prevention bytes are not
/// counted.
std::size_t side_data_bytes(const SideData& data);

/// The depth access unit's essential NAL units, with the side data before the first slice. `color`
/// is the frame's colour access unit, empty if there is none. Requires access units as a
/// PictureEncoder makes them, and data.has_color == !color.empty().
std::vector<std::uint8_t> add_side_data(std::span<const std::uint8_t> depth,
                                        std::span<const std::uint8_t> color, const SideData& data);

/// Reads the side data of a frame. Fails with kCorrupt if the side data, or a slice or parameter
/// set of either picture, is damaged or missing, and on numbers outside the bounds of
/// common/frame/bounds.h.
Result<SideData> extract_side_data(std::span<const std::uint8_t> depth, std::span<const std::uint8_t> color);

}  // namespace copresence::bitstream
