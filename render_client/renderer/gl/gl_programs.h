#pragma once

// The shaders of the GL renderer, a class each: their setters' arguments are the uniforms and bindings of
// shaders/<name>. Constants of merge_rules.h are compiled in. Private to the GL renderer.
//
// Thread: the context's.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <span>

#include "common/frame/camera_model.h"
#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/framebuffer.h"
#include "common/gl/program.h"
#include "common/gl/texture.h"
#include "common/result.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {

/// Planes of inverse depth by block of 4, 8, 16 pixels (kRgba32f), FlatBlocks on the card.
using GlPlanes = std::array<gl::Texture, 3>;
/// The level of kBlockSizes that they begin with: blocks of 2 are not worth a pass on the card.
inline constexpr int kFirstGlLevel = 1;

/// find_flat_blocks.comp: depth (kR16ui) to planes.
class FindFlatBlocks {
 public:
  static Result<FindFlatBlocks> make(gl::Context& context);
  void run(const gl::Texture& depth, float units_per_metre, const SurfaceLimits& limits,
           const GlPlanes& planes);

 private:
  explicit FindFlatBlocks(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// measure_tilts.comp: depth and planes to cos(theta) by cell (kR32f).
class MeasureTilts {
 public:
  static Result<MeasureTilts> make(gl::Context& context);
  void run(const gl::Texture& depth, const GlPlanes& planes, const CameraModel& model, float units_per_metre,
           const gl::Texture& cosines);

 private:
  explicit MeasureTilts(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// make_source.comp: matched colour, or gray where `color` is null, and worth (kRgba8).
class MakeSource {
 public:
  static Result<MakeSource> make(gl::Context& context);
  void run(const gl::Texture& cosines, const gl::Texture& state, const gl::Texture* color,
           const Eigen::Matrix<float, 3, 4>& color_matching, const gl::Texture& source);

 private:
  explicit MakeSource(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// outline_flat_blocks.comp: depth and planes to inverse depth (kR32f) that agrees where blocks meet.
class OutlineFlatBlocks {
 public:
  static Result<OutlineFlatBlocks> make(gl::Context& context);
  /// Blocks larger than `largest_block` pixels a side count as not flat.
  void run(const gl::Texture& depth, const GlPlanes& planes, float units_per_metre, int largest_block,
           const gl::Texture& inverse);

 private:
  explicit OutlineFlatBlocks(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// build_mesh.comp: inverse depth and planes to triangles.
class BuildMesh {
 public:
  static Result<BuildMesh> make(gl::Context& context);
  /// `command` gets a gl::DrawCommand; `indices` has room for six per pixel.
  void run(const gl::Texture& inverse, const GlPlanes& planes, const SurfaceLimits& limits, int largest_block,
           gl::Buffer& command, const gl::Buffer& indices);

 private:
  explicit BuildMesh(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// draw_mesh.vert and .frag: triangles into a layer of colour and worth.
class DrawMesh {
 public:
  static Result<DrawMesh> make(gl::Context& context);
  void run(const gl::Texture& inverse, const gl::Texture& rays, const gl::Texture& source,
           const Eigen::Matrix4f& clip_from_camera, const gl::Buffer& command, const gl::Buffer& indices,
           gl::Framebuffer& layer);

 private:
  explicit DrawMesh(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// fade_layers.comp: fades the layers of stale cameras and removes them where a live camera shows anything.
class FadeLayers {
 public:
  explicit FadeLayers(gl::Context& context) : context_(&context) {}

  /// `opacities`, one per layer: 1 of a live camera. A shader is compiled for each number of layers once.
  Result<void> run(std::span<const float> opacities, const gl::Texture& fragments);

 private:
  gl::Context* context_;
  std::map<std::size_t, gl::Program> programs_;
};

/// merge_layers.comp: the layers to the view.
class MergeLayers {
 public:
  struct Source {
    Eigen::Vector4f axis;  ///< dot with (point in the eye's frame, 1) is the depth along the camera's axis, m
    float calibration_error_m;
    DepthNoise noise;
  };
  struct Eye {
    Eigen::Vector2f w_near_far;      ///< 1/m
    Eigen::Vector4f ray_from_pixel;  ///< xy * pixel + zw
  };
  struct Target {
    const gl::Texture &color, &depth, &camera, &quality;
  };

  explicit MergeLayers(gl::Context& context) : context_(&context) {}

  /// A shader is compiled for each number of sources once. `wants_depth`: else only the colour is written.
  Result<void> run(std::span<const Source> sources, const Eye& eye, const gl::Texture& fragments,
                   const gl::Texture& depths, bool wants_depth, const Target& target);

 private:
  gl::Context* context_;
  std::map<std::size_t, gl::Program> programs_;
};

/// soften_outlines.comp: a merged view's colours to those shown.
class SoftenOutlines {
 public:
  explicit SoftenOutlines(gl::Context& context) : context_(&context) {}

  /// Sources, layers and `w_near_far` as in MergeLayers. A shader is compiled for each number of sources once.
  Result<void> run(std::span<const MergeLayers::Source> sources, const Eigen::Vector2f& w_near_far,
                   const gl::Texture& fragments, const gl::Texture& depths, const gl::Texture& merged,
                   const gl::Texture& softened);

 private:
  gl::Context* context_;
  std::map<std::size_t, gl::Program> programs_;
};

}  // namespace copresence::renderer
