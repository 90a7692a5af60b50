#pragma once

// Which images of a folder belong together, and whether they are depth, colour or something else: by the words of their
// names and by what their headers say. Masks, labels, infrared and coloured pictures of depth lie beside both in public
// data sets.
//
// Thread: free functions; concurrent calls are safe.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace copresence::record {

enum class ImageKind { kDepth, kColor, kOther };

/// What the words of a path, relative to the images' folder, say: those of the file's name before those of its folder.
/// kOther where they name what is neither (mask, label, infrared, ...).
/// `known` is false where no word says anything.
struct NamedKind {
  ImageKind kind = ImageKind::kOther;
  bool known = false;
};
NamedKind kind_by_name(const std::filesystem::path& relative);

/// Whether a file holds one channel of 16 bits or of floating-point numbers, as depth does.
bool holds_depth(const std::filesystem::path& path);

/// Images of one folder and of one kind of name.
struct ImageGroup {
  std::string label;   ///< for people: "depth/", "ir*.png"
  std::string folder;  ///< relative; empty for the images' folder itself
  ImageKind kind = ImageKind::kOther;
  int rank = 0;  ///< among groups of one kind: the lower, the likelier it is meant
  std::vector<std::filesystem::path> paths;  ///< sorted by name
};

struct FolderContent {
  std::vector<ImageGroup> groups;
  std::size_t hidden = 0;  ///< files that systems leave: ._0.png, .DS_Store, __MACOSX
};

/// All images of a folder and of the folders in it.
FolderContent list_images(const std::filesystem::path& folder);

/// The group of this kind that is meant: the one that `wanted` names by label or folder, else that of the lowest rank.
/// Null where there is none.
/// Fails  kNotFound: none is called `wanted`; kInvalid: several are equally likely.
Result<const ImageGroup*> choose(const FolderContent& content, ImageKind kind, const std::string& wanted,
                                 const std::string& folder);

}  // namespace copresence::record
