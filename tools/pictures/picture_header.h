#pragma once

// Reads format and size from the header of an image file. The size must be checked before decoding,
// because a file of a few kilobytes can decode to gigabytes.
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
  int width = 0, height = 0;  ///< Pixels as stored.
  int orientation = 1;        ///< EXIF orientation of a JPEG file, 1 to 8; 1 if there is none.
  int channels = 0;           ///< Number of channels, 1 to 4; a palette counts as 3.
  int bits = 0;               ///< Bits per channel.
  bool is_float = false;      ///< True for floating-point TIFF and PFM.
  bool is_palette = false;    ///< True for PNG palette indices, as in label images.

  std::uint64_t pixels() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
};

/// Default limit of load(), pixels.
inline constexpr std::uint64_t kMostPixels = 100'000'000;

/// Reads bytes from `offset` into `into` and returns their number.
using ReadAt = std::function<std::size_t(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// Reads a header. Messages do not contain a file name.
/// Fails with kUnsupported for a known but unsupported format; the message names the format and a
/// remedy. Fails with kCorrupt for a damaged or unknown format and for an image without a size.
Result<PictureHeader> read_header(const ReadAt& read_at);

/// Reads the header of a file. Messages begin with the file's name. Also fails with kNotFound if
/// the file cannot be read.
Result<PictureHeader> read_header(const std::filesystem::path& path);

/// Reads a whole image file after checking its header.
/// Fails as read_header() does. Fails with kInvalid for more than `most_pixels`, or for a file too
/// large for them.
Result<std::vector<std::uint8_t>> load(const std::filesystem::path& path,
                                       std::uint64_t most_pixels = kMostPixels);

}  // namespace copresence::pictures
