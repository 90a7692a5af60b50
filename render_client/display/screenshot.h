#pragma once

// A view as a PNG file.
// Thread: pure.

#include <string>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::client {

/// Fails with a sentence that names the file. What the view does not show is written in its own colour,
/// opaque.
Result<void> write_png(const std::string& path, const Image<Rgba8>& image);

}  // namespace copresence::client
