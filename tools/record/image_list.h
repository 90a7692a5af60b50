#pragma once

// Lists of images: TUM's "time file" and pairs "time file time file", as people's tools and editors write them.
//
// Thread: free functions on values, safe anywhere.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "tools/record/time_reading.h"

namespace copresence::record {

/// An image that a list names.
struct ListedImage {
  TimeNumber time;
  std::filesystem::path path;
};

/// One line of a list.
struct ListLine {
  int number = 0;  ///< from 1
  std::vector<ListedImage> images;
};

/// Reads lines of `images_per_line` pairs of a time and a file's name, relative to `folder`. Fields are separated by
/// white space, commas or semicolons. A name may be in quotes, and may have spaces where it ends like an image's.
/// Lines that begin with # are comments; a byte order mark, a first line of column names, Windows line ends and fields
/// behind the last name are passed over. `name` stands for the list in sentences.
/// Fails  kInvalid: a line that is none, with its number.
Result<std::vector<ListLine>> parse_list(std::string_view text, const std::filesystem::path& folder,
                                         const std::string& name, std::size_t images_per_line);

/// Whether a file's name ends like an image's, of a format that is read here or not.
bool has_image_ending(const std::filesystem::path& path);

}  // namespace copresence::record
