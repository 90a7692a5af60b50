#pragma once

// Holds one camera's frame, texture and triangles on the graphics card until the frame changes.
// Thread: only the thread of the OpenGL context.

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/texture.h"
#include "render_client/renderer/gl/gl_programs.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

class GlCamera {
 public:
  /// The shaders that prepare a frame, shared by all cameras.
  struct Shaders {
    FindPlanarBlocks planar_blocks;
    MeasureIncidence incidence;
    StitchPlanarBlocks stitching;
    BuildMesh mesh;
    MakeCameraTexture texture;
  };

  GlCamera(gl::Context& context, const CameraModel& model, int largest_block);

  int width() const { return depth_.width(); }
  int height() const { return depth_.height(); }

  const gl::Texture& inverse() const { return inverse_; }  ///< 1/m, 0 without depth.
  const gl::Texture& texture() const { return texture_; }  ///< As make_camera_texture.comp writes it.

  /// Prepares the frame if it is new. Requires a model of the same size as in the constructor.
  void update(const CameraView& camera, Shaders& shaders);

  void draw(const Eigen::Matrix4f& clip_from_camera, DrawMesh& program, gl::Framebuffer& layer) const;

 private:
  gl::Context* context_;
  int largest_block_;
  CameraModel model_;
  gl::Texture rays_, depth_, state_, color_, inverse_, incidences_, texture_;
  GlPlanes planes_;
  Image<float> shading_;  // The cos(theta) of each cell, used if the camera has no colour.
  gl::Buffer command_, indices_;

  // The frame and settings that the textures above were made from.
  std::optional<std::uint64_t> version_;
  const RgbdFrame* frame_ = nullptr;
  Eigen::Matrix<float, 3, 4> color_correction_;
  DepthUnit unit_ = DepthUnit::kMillimetre;
  DepthNoise noise_;
};

}  // namespace copresence::renderer
