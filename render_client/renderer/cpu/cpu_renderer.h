#pragma once

// The renderer without a GPU: every camera's surface is drawn by band of rows, and a band is merged and
// coloured while it is in the cache. The fast one wherever OpenGL is software; docs/internals/rendering.md has the
// method and the figures.
//
// Thread: as any Renderer. It uses the workers only inside render(). The pictures do not depend on how many
// there are.

#include <memory>

#include "common/executor.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

struct CpuRendererSettings {
  /// Flat regions are drawn in blocks of up to so many pixels a side: 1, 4, 8 or 16. 1 draws every pixel.
  int largest_block = 16;
};

/// `workers` must outlive the renderer.
std::unique_ptr<Renderer> make_cpu_renderer(Executor& workers, const CpuRendererSettings& settings = {});

}  // namespace copresence::renderer
