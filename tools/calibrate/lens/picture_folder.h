#pragma once

// Photographs from a folder, as the sensor saw them: the orientation that a JPEG file names is not applied, since it differs
// from picture to picture while the lens stays the same.

#include <filesystem>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibrate {

/// The PNG and JPEG pictures of one camera in a folder.
struct PictureFolder {
  std::vector<std::filesystem::path> files;  ///< by name; hidden ones left out
  int width = 0, height = 0;                 ///< pixels that are used: even
  std::string remark;                        ///< what a person should know about them; may be empty
};

/// Reads the headers of all pictures.
/// Fails  kNotFound where there are none; kCorrupt for a file that is no picture; kInvalid where sizes differ, naming the
///        odd ones out, and for sizes that no camera model can have.
Result<PictureFolder> open_picture_folder(const std::filesystem::path& folder);

/// Decodes one of its files. The last column or row of an odd size is left out.
/// Fails  kCorrupt where the file is damaged.
Result<ColorImage> load_picture(const PictureFolder& folder, const std::filesystem::path& file);

}  // namespace copresence::calibrate
