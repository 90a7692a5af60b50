#pragma once

// Side data: the parts of a frame that must arrive exactly. Side data consists of metadata,
// validity mask, codebook change and residuals. The depth access unit holds the side data in one
// SEI message of type user_data_unregistered, with our own UUID. So every copy of the stream (wire,
// Matroska, MPEG-TS, a relay) keeps the side data with its picture.
//
// A CRC-32 over the side data and both coded pictures detects damage, missing parts, and pictures
// of different frames. See docs/internals/sei.md for the layout. The test
// SideData.HasTheDocumentedBytes checks that page. Thread: pure.

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
  std::uint64_t previous = 0;  ///< Sequence of the frame that this one needs; 0 in a keyframe.
  Instant captured_at{};       ///< Capture time on the capture process's monotonic clock, never negative.
  std::uint8_t qp = 0;         ///< QP of the depth picture; 0 means lossless.
  bool has_color = false;      ///< True if this frame has a colour access unit.
  std::optional<Rigid3> world_from_camera;  ///< Absent if unchanged since the frame before.
  std::vector<std::uint8_t> table;
  std::vector<std::uint8_t> residuals;  ///< Losslessly coded depth; the picture is then blank.
  std::vector<std::uint8_t> validity_mask;

  friend bool operator==(const SideData&, const SideData&) = default;
};

/// Size of the side data in the access unit, in bytes, without emulation prevention bytes.
std::size_t side_data_bytes(const SideData& data);

/// Returns the depth access unit's essential NAL units, with the side data before the first slice.
/// `color` is the frame's colour access unit, or empty. Requires access units from a
/// PictureEncoder, and data.has_color == !color.empty().
std::vector<std::uint8_t> add_side_data(std::span<const std::uint8_t> depth,
                                        std::span<const std::uint8_t> color, const SideData& data);

/// Reads the side data of a frame. Fails with kCorrupt if the side data, a slice or a parameter set
/// of either picture is damaged or missing. Numbers outside the bounds of common/frame/bounds.h
/// fail, too.
Result<SideData> extract_side_data(std::span<const std::uint8_t> depth, std::span<const std::uint8_t> color);

}  // namespace copresence::bitstream
