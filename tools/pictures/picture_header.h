#pragma once

// Format and size of an image file, read from its first bytes. A file of a few kilobytes can unpack to gigabytes, so
// its size is checked before anything decodes it.
//
// Thread: free functions; concurrent calls are safe.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace copresence::pictures {

enum class Format { kPng, kJpeg, kNetpbm, kTiff, kPfm };

struct PictureHeader {
  Format format = Format::kPng;
  int width = 0, height = 0;  ///< pixels as stored
  int orientation = 1;  ///< JPEG: how a viewer should turn the picture, EXIF's 1 to 8; 1 where none is named
  int channels = 0;     ///< 1 to 4; a palette counts as 3
  int bits = 0;         ///< per channel
  bool is_float = false;    ///< TIFF and PFM
  bool is_palette = false;  ///< PNG: colours by number, as label images have them

  std::uint64_t pixels() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
};

/// The largest picture that load() takes, pixels.
inline constexpr std::uint64_t kMostPixels = 100'000'000;

/// Copies bytes from `offset` on into `into`; returns how many there were.
using ReadAt = std::function<std::size_t(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// Fails  kUnsupported for a known format that is not read here: the sentence names it and says what to do;
///        kCorrupt for anything else that is no image, and for one without a size. Sentences have no file's name.
Result<PictureHeader> read_header(const ReadAt& read_at);

/// The same for a file; sentences begin with its name. Fails also with kNotFound where it cannot be read.
Result<PictureHeader> read_header(const std::filesystem::path& path);

/// All bytes of an image file whose header is sound and that has at most `most_pixels`.
/// Fails  as read_header(); kInvalid for a larger image or a file that is larger than such an image can be.
Result<std::vector<std::uint8_t>> load(const std::filesystem::path& path,
                                       std::uint64_t most_pixels = kMostPixels);

}  // namespace copresence::pictures
