#pragma once

// Writes a view to a PNG file.
//
// Thread: pure.

#include <string>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::display {

/// Fails with a message that names the file. Alpha is dropped: all pixels are opaque.
Result<void> write_png(const std::string& path, const Image<Rgba8>& image);

}  // namespace copresence::display
