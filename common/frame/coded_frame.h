#pragma once

// A frame on its way through the codecs: first as pictures (PlanarFrame), then as H.264
// (EncodedFrame).

#include <cstdint>
#include <optional>
#include <vector>

#include "common/frame/picture.h"
#include "common/frame/rgbd_frame.h"

namespace copresence {

/// The output of a depth codec: a picture for the video codec, and the bytes that must arrive
/// exactly.
struct PlanarDepth {
  bool keyframe = false;  ///< decodes without any earlier frame
  /// Input of the video encoder, which may change it. Holes have arbitrary values. Empty if
  /// `residuals` is used.
  Picture picture;
  /// QP of the encoded picture, on H.264's scale for its bit depth; 0 if the coding was lossless.
  int qp = 0;
  std::vector<std::uint8_t> residuals;      ///< the picture coded without loss, instead of `picture`
  std::vector<std::uint8_t> validity_mask;  ///< coded states of all pixels, lossless
  std::vector<std::uint8_t> table;          ///< coded change of the codebook; empty for codecs without one
};

struct PlanarFrame {
  FrameMetadata metadata;
  PlanarDepth depth;
  std::optional<Picture> color;  ///< kYuv420, full range BT.601
  StageDurations durations;
};

/// A frame as it is sent: H.264 access units in Annex B form.
struct EncodedFrame {
  bool keyframe = false;            ///< both pictures are IDR pictures, mask and codebook are complete
  std::uint64_t sequence = 0;       ///< as in the metadata inside `depth`
  std::vector<std::uint8_t> depth;  ///< one access unit; its SEI carries metadata, mask and codebook
  std::vector<std::uint8_t> color;  ///< one access unit of the same instant; empty if there is no colour
  StageDurations durations;
};

}  // namespace copresence
