#pragma once

// The renderer on a graphics card. Every camera's triangles are found by a compute shader and drawn from the
// eye into a layer of their own; a compute shader merges the layers. docs/rendering.md has the method and the
// figures.
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
/// the next render() or the renderer's end. Fails  kInvalid where the driver does not compile the shaders, in
/// the driver's words.
Result<std::unique_ptr<Renderer>> make_gl_renderer(gl::Context& context,
                                                   const GlRendererSettings& settings = {});

}  // namespace copresence::renderer
