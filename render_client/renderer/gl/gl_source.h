#pragma once

// One camera on the graphics card: its frame, what its fragments look like and are worth, and its triangles.
// Kept until the frame changes. Private to the GL renderer.
//
// Thread: the context's.

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/texture.h"
#include "render_client/renderer/gl/gl_programs.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

class GlSource {
 public:
  /// The shaders that prepare a frame, shared by all cameras.
  struct Shaders {
    FindFlatBlocks flat_blocks;
    MeasureTilts tilts;
    OutlineFlatBlocks outlines;
    BuildMesh mesh;
    MakeSource look;
  };

  /// For frames of the size of `model`.
  GlSource(gl::Context& context, const CameraModel& model, int largest_block);

  int width() const { return depth_.width(); }
  int height() const { return depth_.height(); }

  /// Brings in what is new in `camera`, whose model has this size.
  void update(const CameraView& camera, Shaders& shaders);

  void draw(const Eigen::Matrix4f& clip_from_camera, DrawMesh& program, gl::Framebuffer& layer) const;

 private:
  gl::Context* context_;
  int largest_block_;
  CameraModel model_;
  gl::Texture rays_, depth_, state_, color_, inverse_, cosines_, source_;
  GlPlanes planes_;
  gl::Buffer command_, indices_;

  // What the textures above were made from.
  std::optional<std::uint64_t> version_;
  const RgbdFrame* frame_ = nullptr;
  Eigen::Matrix<float, 3, 4> color_matching_;
  DepthUnit unit_ = DepthUnit::kMillimetre;
  DepthNoise noise_;
};

}  // namespace copresence::renderer
