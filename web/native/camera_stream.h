#pragma once

// Turns one camera's stream into surfaces for the browser's viewer page. This is the client's code
// from the frame to the mesh, except for two steps: the browser decodes the H.264 pictures, and
// WebGL draws the mesh.
//
// A frame passes begin(), then the browser's video decoders, then finish(). Every frame must pass
// them, since later frames depend on it. make_surface() is needed only for frames that are shown.
// Thread: one thread at a time.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/bitstream/frame_chain.h"
#include "common/depth/depth_codec.h"
#include "common/frame/coded_frame.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "render_client/background_memory/background_memory.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/decoding/frame_conditioning.h"
#include "render_client/renderer/cpu/camera_surface.h"

namespace copresence::web {

class CameraStream {
 public:
  /// Fails if the description names an unknown codec or has impossible parameters.
  static Result<std::unique_ptr<CameraStream>> open(const StreamDescription& description);

  const StreamDescription& description() const { return description_; }

  /// Reads and checks the side data of the next frame. Fails for a damaged frame and if a frame is
  /// missing before it. The caller should then request a keyframe.
  Result<void> begin(EncodedFrame encoded);

  /// The access units that the browser must decode for this frame. Empty if there is nothing to
  /// decode: a lossless frame has its depth in the side data.
  std::span<const std::uint8_t> depth_access_unit() const;
  std::span<const std::uint8_t> color_access_unit() const { return encoded_.color; }
  bool is_keyframe() const { return planar_.depth.keyframe; }
  const FrameMetadata& metadata() const { return planar_.metadata; }

  /// The pictures into which the browser copies its decoded planes.
  Picture& depth_picture() { return depth_picture_; }
  Picture& color_picture() { return color_picture_; }
  /// Takes the place of color_picture() in a browser that returns RGBA pixels instead of planes.
  std::span<std::uint8_t> color_pixels();

  enum class Color { kNone, kPlanes, kPixels };
  /// Decodes depth after the browser has decoded the pictures. `color` states where it has put the
  /// colours. Fails as depth::Decoder::decode() does.
  Result<void> finish(Color color);

  /// Call it if the browser could not decode a picture. Then only a keyframe is accepted.
  void abandon() { chain_.await_keyframe(); }

  /// Sets the correction to the reference camera's colours, for the surfaces from now on.
  void set_color_correction(const Eigen::Matrix<float, 3, 4>& correction) { color_correction_ = correction; }

  /// Surfaces from now on are made of every `step`-th pixel of every `step`-th row. Larger steps
  /// suit slow graphics. Requires 1, 2 or 4.
  void set_step(int step) { step_ = step; }

  /// Conditions the finished frame for display, and makes its surface and that of the remembered
  /// background. Call it once at most for a frame.
  void make_surface();

  const RgbdFrame& frame() const { return frame_; }
  /// The frame of which surface() is made: frame(), or some of its pixels.
  const RgbdFrame& surface_frame() const { return step_ == 1 ? frame_ : thinned_; }
  const renderer::CameraSurface& surface() const { return surface_; }
  /// The remembered background (background_memory.h), or null if nothing is covered.
  const RgbdFrame* remembered() const { return remembered_.get(); }
  const renderer::CameraSurface& remembered_surface() const { return remembered_surface_; }
  /// Changes whenever remembered_surface() is another one.
  std::uint64_t remembered_version() const { return remembered_version_; }

 private:
  CameraStream(const StreamDescription& description, depth::Decoder decoder);
  void take_color(Color color);
  renderer::CameraView view(const RgbdFrame& frame, std::uint64_t version) const;

  StreamDescription description_;
  client::CameraSetup setup_;
  bitstream::FrameChain chain_;
  depth::Decoder decoder_;
  decoding::FrameConditioner conditioner_;
  background_memory::BackgroundMemory background_;

  EncodedFrame encoded_;
  PlanarFrame planar_;
  Picture depth_picture_, color_picture_;
  std::vector<std::uint8_t> color_pixels_;
  RgbdFrame frame_;
  std::optional<ColorImage> newest_color_;
  Instant newest_color_at_{};  // Capture time on the server's clock.

  Eigen::Matrix<float, 3, 4> color_correction_ = Eigen::Matrix<float, 3, 4>::Identity();
  Eigen::Matrix<float, 3, 4> remembered_correction_ = color_correction_;
  int step_ = 1, remembered_step_ = 1;
  RgbdFrame thinned_;  // Of frame_, if step_ is not 1.
  std::uint64_t version_ = 0, remembered_version_ = 0;
  renderer::CameraSurface surface_, remembered_surface_;
  std::shared_ptr<const RgbdFrame> remembered_;
};

}  // namespace copresence::web
