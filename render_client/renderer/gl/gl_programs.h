#pragma once

// The shaders of the GL renderer, one class each. The arguments of run() become uniforms and
// bindings. Constants of merge_rules.h are compiled in. Thread: only the thread of the OpenGL
// context.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>

#include "common/frame/camera_model.h"
#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/framebuffer.h"
#include "common/gl/program.h"
#include "common/gl/texture.h"
#include "common/result.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// PlanarBlocks on the graphics card: planes for blocks of 4, 8 and 16 pixels (kRgba32f).
using GlPlanes = std::array<gl::Texture, 3>;
/// Index of 4x4 blocks in kBlockSizes. On a graphics card, 2x2 blocks cost more than they save.
inline constexpr int kFirstGlLevel = 1;

/// Finds planes in depth (kR16ui): find_planar_blocks.comp.
class FindPlanarBlocks {
 public:
  static Result<FindPlanarBlocks> make(gl::Context& context);
  void run(const gl::Texture& depth, float units_per_metre, const SurfaceLimits& limits,
           const GlPlanes& planes);

 private:
  explicit FindPlanarBlocks(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// Computes cos(theta) of each cell (kR32f) from depth and planes: measure_incidence.comp.
class MeasureIncidence {
 public:
  static Result<MeasureIncidence> make(gl::Context& context);
  void run(const gl::Texture& depth, const GlPlanes& planes, const CameraModel& model, float units_per_metre,
           const gl::Texture& incidences);

 private:
  explicit MeasureIncidence(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// Computes corrected colours, or gray if `color` is null, and weights (kRgba8):
/// make_camera_texture.comp.
class MakeCameraTexture {
 public:
  static Result<MakeCameraTexture> make(gl::Context& context);
  void run(const gl::Texture& incidences, const gl::Texture& depth, const gl::Texture& state,
           const gl::Texture* color, const Eigen::Matrix<float, 3, 4>& color_correction,
           const gl::Texture& camera_texture);

 private:
  explicit MakeCameraTexture(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// Computes inverse depth (kR32f) without cracks between blocks: stitch_planar_blocks.comp.
class StitchPlanarBlocks {
 public:
  static Result<StitchPlanarBlocks> make(gl::Context& context);
  /// Blocks larger than `largest_block` pixels a side are divided.
  void run(const gl::Texture& depth, const GlPlanes& planes, float units_per_metre, int largest_block,
           const gl::Texture& inverse);

 private:
  explicit StitchPlanarBlocks(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// Makes triangles from inverse depth and planes: build_mesh.comp.
class BuildMesh {
 public:
  static Result<BuildMesh> make(gl::Context& context);
  /// Writes a gl::DrawCommand to `command`. Requires room for six `indices` per pixel.
  void run(const gl::Texture& inverse, const GlPlanes& planes, const SurfaceLimits& limits, int largest_block,
           gl::Buffer& command, const gl::Buffer& indices);

 private:
  explicit BuildMesh(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// Draws triangles into a layer of colours and weights: draw_mesh.vert and draw_mesh.frag.
class DrawMesh {
 public:
  static Result<DrawMesh> make(gl::Context& context);
  void run(const gl::Texture& inverse, const gl::Texture& rays, const gl::Texture& camera_texture,
           const Eigen::Matrix4f& clip_from_camera, const gl::Buffer& command, const gl::Buffer& indices,
           gl::Framebuffer& layer);

 private:
  explicit DrawMesh(gl::Program program) : program_(std::move(program)) {}
  gl::Program program_;
};

/// Fades the layers of stale cameras and of remembered backgrounds, and clears them where a layer
/// of a lower rank shows anything: fade_layers.comp. A shader is compiled once for each number of
/// layers.
class FadeLayers {
 public:
  explicit FadeLayers(gl::Context& context) : context_(&context) {}

  struct Layer {
    float opacity;
    Rank rank;
  };
  Result<void> run(std::span<const Layer> layers, const gl::Texture& fragments);

 private:
  gl::Context* context_;
  std::map<std::size_t, gl::Program> programs_;
};

/// Uniforms that depend on the view's pose and projection only.
struct ViewUniforms {
  Eigen::Vector2f w_near_far;      ///< Inverse depth of the near and the far plane, 1/m.
  Eigen::Vector4f ray_from_pixel;  ///< The ray (x, y) at z = 1 is xy * pixel + zw.
};

/// Merges the layers into the view: merge_layers.comp. It compiles a shader per number of cameras.
class MergeLayers {
 public:
  struct Camera {
    /// The dot product of `axis` and (x, y, z, 1) of a point in the eye's frame is the point's
    /// depth along the camera's axis, m.
    Eigen::Vector4f axis;
    float calibration_error_m;
    DepthNoise noise;
  };
  struct Target {
    const gl::Texture &color, &depth, &camera, &quality;
  };

  explicit MergeLayers(gl::Context& context) : context_(&context) {}

  /// Without `wants_depth`, only the colour is written.
  Result<void> run(std::span<const Camera> cameras, MergeMode mode, const ViewUniforms& view,
                   const gl::Texture& fragments, const gl::Texture& depths, bool wants_depth,
                   const Target& target);

 private:
  gl::Context* context_;
  std::map<std::size_t, gl::Program> programs_;
};

/// Softens the silhouette edges of a merged view: soften_silhouettes.comp. A shader is compiled
/// once for each number of cameras.
class SoftenSilhouettes {
 public:
  explicit SoftenSilhouettes(gl::Context& context) : context_(&context) {}

  Result<void> run(std::span<const MergeLayers::Camera> cameras, const Eigen::Vector2f& w_near_far,
                   const gl::Texture& fragments, const gl::Texture& depths, const gl::Texture& merged,
                   const gl::Texture& scratch, const gl::Texture& softened);

 private:
  gl::Context* context_;
  std::map<std::size_t, gl::Program> programs_;
};

/// Fills the empty pixels of a view (extension_rules.h): extend_blocks.comp, extend_estimate.comp,
/// extend_smooth.comp, extend_view.comp and extend_colors.comp.
class ExtendBackground {
 public:
  struct Camera {
    Eigen::Matrix<float, 3, 4> camera_from_eye;
    CameraModel model;
    bool is_drawn, is_remembered;
    const gl::Texture* inverse;  ///< Inverse depth of each pixel, 1/m.
    const gl::Texture* colors;   ///< Corrected colours; null if the camera has none.
    float opacity;
  };

  explicit ExtendBackground(gl::Context& context) : context_(&context) {}

  /// Changes colour (kRgba8) and depth (kR32f, m) where depth is 0. Sets the origins (kR8ui).
  /// `camera` is the image MergedView::camera (kR8ui).
  Result<void> run(std::span<const Camera> cameras, const ViewUniforms& view, float near_m,
                   const UnseenStyle& style, const gl::Texture& color, const gl::Texture& depth,
                   const gl::Texture& camera, const gl::Texture& origin);

 private:
  struct Blocks {
    gl::Texture surfaces, estimates, gaps;
  };
  Result<void> compile(std::size_t cameras);
  void estimate_blocks(const gl::Texture& color, const gl::Texture& depth);
  void take_colors(std::span<const Camera> cameras, const ViewUniforms& view, float brightness,
                   const gl::Texture& color, const gl::Texture& depth, const gl::Texture& origin);

  gl::Context* context_;
  std::optional<gl::Program> summarise_, estimate_, smooth_, take_colors_;
  std::map<std::size_t, gl::Program> fill_;
  std::optional<Blocks> blocks_;
};

}  // namespace copresence::renderer
