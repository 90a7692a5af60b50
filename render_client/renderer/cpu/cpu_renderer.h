#pragma once

// The renderer that needs no GPU. It draws the view in tiles of rows, and merges each tile while
// its data are in the cache. It is faster than the GL renderer on a software OpenGL.
// docs/internals/rendering.md explains the method and states measurements. Thread: one thread
// makes, uses and destroys a renderer. It uses the workers only inside render() and prepare(). The
// pictures do not depend on the number of workers.

#include <memory>

#include "common/executor.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

struct CpuRendererSettings {
  /// Planar regions are drawn in blocks of up to this many pixels a side: 1, 4, 8 or 16. With 1,
  /// all pixels are drawn one by one.
  int largest_block = 16;
};

/// `workers` must outlive the renderer.
std::unique_ptr<Renderer> make_cpu_renderer(Executor& workers, const CpuRendererSettings& settings = {});

}  // namespace copresence::renderer
