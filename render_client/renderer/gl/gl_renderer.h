#pragma once

// The renderer that runs on a graphics card. It follows the same rules and draws the same meshes as
// the CPU renderer. These shaders run once for each new frame:
//
//   find_planar_blocks    Fits planes of inverse depth to blocks.
//   measure_incidence     Computes cos(theta) from planes and depth.
//   stitch_planar_blocks  Closes cracks between blocks.
//   build_mesh            Makes triangles.
//   make_camera_texture   Computes the colours and weights of fragments.
//
// These shaders run once for each view:
//
//   draw_mesh             Draws each camera's triangles into its own layer.
//   fade_layers           Fades stale cameras, if there are any.
//   merge_layers          Merges the layers into the view.
//   soften_silhouettes    Softens edges where depth jumps.
//   extend_*              Fill pixels that no camera has seen.
//
// Thread: only the thread of the OpenGL context.

#include <memory>

#include "common/gl/context.h"
#include "common/result.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

struct GlRendererSettings {
  /// As in CpuRendererSettings.
  int largest_block = 16;
};

/// `context` must outlive the renderer. Fails with kInvalid and the driver's message if the driver
/// cannot compile a shader.
Result<std::unique_ptr<Renderer>> make_gl_renderer(gl::Context& context,
                                                   const GlRendererSettings& settings = {});

}  // namespace copresence::renderer
