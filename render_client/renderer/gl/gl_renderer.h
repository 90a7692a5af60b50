#pragma once

// The renderer on a graphics card. It follows the same rules and draws the same meshes as the CPU
// renderer. Its steps are shaders in shaders/:
//
//   once a frame
//     find_planar_blocks    fits planes of inverse depth to blocks
//     measure_incidence     computes cos(theta) from planes and depth
//     stitch_planar_blocks  closes cracks between blocks
//     build_mesh            makes triangles
//     make_camera_texture   computes the colours and weights of fragments
//   once a view
//     draw_mesh             draws each camera's triangles into its own layer
//     fade_layers           fades stale cameras, if there are any
//     merge_layers          merges the layers into the view
//     soften_silhouettes    softens edges where depth jumps
//
// Thread: the context's.

#include <memory>

#include "common/gl/context.h"
#include "common/result.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

struct GlRendererSettings {
  /// Planar regions are drawn in blocks of up to this many pixels a side: 1, 4, 8 or 16. 1 draws
  /// every pixel.
  int largest_block = 16;
};

/// `context` must outlive the renderer. Fails with kInvalid if the driver does not compile the
/// shaders, in the driver's words.
Result<std::unique_ptr<Renderer>> make_gl_renderer(gl::Context& context,
                                                   const GlRendererSettings& settings = {});

}  // namespace copresence::renderer
