#pragma once

// Writes a view to a PNG file. Thread: pure functions.

#include <string>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::display {

/// Writes the image with its alpha if a pixel is not opaque, else without. Fails with a message that
/// names the file.
Result<void> write_png(const std::string& path, const Image<Rgba8>& image);

}  // namespace copresence::display
