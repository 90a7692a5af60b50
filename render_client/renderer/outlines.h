#pragma once

// Softens the outlines of what stands before something else, as merge_rules.h says (Outlines). Private to the CPU
// renderer. Thread: distinct bands are independent.

#include <span>

#include "render_client/renderer/band.h"
#include "render_client/renderer/merged_view.h"

namespace copresence::renderer {

/// Changes the colours of a band's rows, which merge_band() has written. `bands` are one per camera, all of the same
/// rows.
void soften_outlines(std::span<const Band> bands, MergedView& view);

}  // namespace copresence::renderer
