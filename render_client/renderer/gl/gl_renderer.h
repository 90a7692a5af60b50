#pragma once

// The renderer on a graphics card, by the same rules and with the same meshes as the CPU renderer. In
// shaders/:
//
//   once a frame    find_flat_blocks     depth to planes of inverse depth by block
//                   measure_tilts        planes to cos(theta)
//                   outline_flat_blocks  depth and planes to inverse depth without cracks between blocks
//                   build_mesh           that to triangles
//                   make_source          colour, state and cos(theta) to what a fragment shows and is worth
//   once a view     draw_mesh            every camera's triangles into a layer of their own
//                   fade_layers          what stale cameras show, where there are any
//                   merge_layers         the layers to the view
//                   soften_outlines      the view without steps where depth jumps
//
// Thread: the context's.

#include <memory>

#include "common/gl/context.h"
#include "common/result.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

struct GlRendererSettings {
  /// Flat regions are drawn in blocks of up to so many pixels a side: 1, 4, 8 or 16. 1 draws every pixel.
  int largest_block = 16;
};

/// `context` must outlive the renderer. MergedView::texture is the renderer's own: it holds the view until
/// the next render() or the renderer's end.
/// Fails: kInvalid where the driver does not compile the shaders, in the driver's words.
Result<std::unique_ptr<Renderer>> make_gl_renderer(gl::Context& context,
                                                   const GlRendererSettings& settings = {});

}  // namespace copresence::renderer
