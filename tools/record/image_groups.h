#pragma once

// Sorts the images of a folder into groups of depth, colour and others, by the words in their names
// and by their headers. Public data sets also contain masks, labels, infrared images and
// visualisations of depth. Thread: free functions; concurrent calls are safe.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace copresence::record {

enum class ImageKind { kDepth, kColor, kOther };

/// The kind of an image according to the words in its path. Words of the file name have precedence
/// over those of folders. Words such as mask, label or infrared mean kOther. If no word has a
/// meaning, `known` is false.
struct NamedKind {
  ImageKind kind = ImageKind::kOther;
  bool known = false;
};
/// Requires a path relative to the folder of images.
NamedKind kind_by_name(const std::filesystem::path& relative);

/// True if a file name has an image extension, including those of unsupported formats.
bool has_image_ending(const std::filesystem::path& path);

/// True if an image has one channel of 16 bits or of floating-point numbers, as depth has.
bool holds_depth(const std::filesystem::path& path);

/// Images in one folder with similar names.
struct ImageGroup {
  std::string label;   ///< Name for messages, such as "depth/" or "ir*.png".
  std::string folder;  ///< The group's folder, relative to that of the images; may be empty.
  ImageKind kind = ImageKind::kOther;
  /// In groups of the same kind, the lowest rank is the most likely group.
  int rank = 0;
  std::vector<std::filesystem::path> paths;
};

struct FolderContent {
  std::vector<ImageGroup> groups;
  std::size_t hidden = 0;  ///< Number of files of operating systems: ._0.png, .DS_Store, __MACOSX.
};

/// Lists all images in a folder and in its direct subfolders.
FolderContent list_images(const std::filesystem::path& folder);

/// Chooses a group of this kind by its label or folder `wanted`. If `wanted` is empty, chooses the
/// group with the lowest rank. Returns null if there is no group. `folder` is for messages.
/// Fails with kNotFound if no group is called `wanted`, and with kInvalid if several have that
/// rank.
Result<const ImageGroup*> choose(const FolderContent& content, ImageKind kind, const std::string& wanted,
                                 const std::string& folder);

}  // namespace copresence::record
