#pragma once

// Pictures from a folder.

#include <filesystem>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibrate {

/// The PNG and JPEG files of a folder, by name. Fails  kNotFound where there is none.
Result<std::vector<std::filesystem::path>> picture_files(const std::filesystem::path& folder);

/// Fails  kCorrupt where the file is no picture.
Result<ColorImage> load_picture(const std::filesystem::path& file);

}  // namespace copresence::calibrate
