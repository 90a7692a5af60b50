#pragma once

// The renderer without a GPU. It draws the view in tiles of rows, and merges each tile while it is
// in the cache. It is the faster one wherever OpenGL is software. docs/internals/rendering.md has
// the method and its measurements.
//
// Thread: as any Renderer. It uses the workers only inside render() and prepare(). The pictures do
// not depend on the number of workers.

#include <memory>

#include "common/executor.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

struct CpuRendererSettings {
  /// Planar regions are drawn in blocks of up to this many pixels a side: 1, 4, 8 or 16. 1 draws
  /// every pixel.
  int largest_block = 16;
};

/// `workers` must outlive the renderer.
std::unique_ptr<Renderer> make_cpu_renderer(Executor& workers, const CpuRendererSettings& settings = {});

}  // namespace copresence::renderer
