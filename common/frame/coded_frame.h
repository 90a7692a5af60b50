#pragma once

// A frame between capture and display in coded form: as pictures (PlanarFrame), then as H.264
// (EncodedFrame).

#include <cstdint>
#include <optional>
#include <vector>

#include "common/frame/picture.h"
#include "common/frame/rgbd_frame.h"

namespace copresence {

/// Output of a depth codec: a picture for the video codec, and the bytes that must arrive exactly.
struct PlanarDepth {
  bool keyframe = false;  ///< True if the frame decodes without any earlier frame.
  /// Input of the video encoder, which may change it. Holes have arbitrary values. The picture is
  /// empty if `residuals` is used.
  Picture picture;
  /// QP of the encoded picture, on H.264's scale for its bit depth; 0 if the coding was lossless.
  int qp = 0;
  std::vector<std::uint8_t> residuals;      ///< Losslessly coded picture, used instead of `picture`.
  std::vector<std::uint8_t> validity_mask;  ///< Losslessly coded states of all pixels.
  std::vector<std::uint8_t> table;          ///< Coded codebook change; empty for codecs without a codebook.
};

struct PlanarFrame {
  FrameMetadata metadata;
  PlanarDepth depth;
  std::optional<Picture> color;  ///< kYuv420, full-range BT.601.
  StageDurations durations;
};

/// A frame in the form that is sent, H.264 access units in Annex B form.
struct EncodedFrame {
  bool keyframe = false;            ///< True if the frame decodes without any earlier frame.
  std::uint64_t sequence = 0;       ///< The same number as in the metadata inside `depth`.
  std::vector<std::uint8_t> depth;  ///< One access unit; its SEI carries the side data.
  std::vector<std::uint8_t> color;  ///< One access unit; empty if there is no colour.
  StageDurations durations;
};

}  // namespace copresence
