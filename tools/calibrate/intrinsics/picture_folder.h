#pragma once

// Reads photographs from a folder. The orientation in a JPEG file (EXIF) is not applied, because
// intrinsics are those of the unrotated sensor.

#include <filesystem>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibrate {

/// The PNG and JPEG pictures of one camera in a folder.
struct PictureFolder {
  std::vector<std::filesystem::path> files;  ///< Sorted by name, without hidden files.
  int width = 0, height = 0;                 ///< Size of the loaded pictures, pixels; even.
  std::string remark;                        ///< Message for the user; may be empty.
};

/// Reads the headers of all pictures.
/// Fails with kNotFound if there are none, and with kCorrupt for a file that is not a picture.
/// Fails with kInvalid if the sizes differ, or if no camera model can have the size.
Result<PictureFolder> open_picture_folder(const std::filesystem::path& folder);

/// Decodes one of the files, without the last column or row of an odd size.
/// Fails with kCorrupt if the file is damaged.
Result<ColorImage> load_picture(const PictureFolder& folder, const std::filesystem::path& file);

}  // namespace copresence::calibrate
