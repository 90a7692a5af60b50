#include "tools/pictures/picture_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <optional>
#include <string_view>

namespace copresence::pictures {
namespace {

constexpr std::size_t kBeginning = 512;  // Enough bytes to recognise every format.

// Limits of a file's size: bytes per pixel, plus bytes of metadata.
constexpr std::uint64_t kBytesPerPixel = 8, kMetadataBytes = 64 << 20;

using Bytes = std::span<const std::uint8_t>;

bool begins_with(Bytes bytes, std::string_view text, std::size_t at = 0) {
  return bytes.size() >= at + text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

tl::unexpected<Error> broken() {
  return fail(ErrorCode::kCorrupt, "the image is damaged; use another copy");
}

struct ForeignFormat {
  std::string_view begin;
  std::size_t at;
  const char* name;
  const char* remedy;
};

constexpr const char* kConvert = "convert it to PNG, for example with ImageMagick: magick IMAGE IMAGE.png";

using std::string_view_literals::operator""sv;

constexpr ForeignFormat kForeignFormats[] = {
    {"\x00\x05\x16\x07"sv, 0, "a macOS resource file", "delete it; the image has the same name without ._"},
    {"GIF8"sv, 0, "a GIF image", kConvert},
    {"BM"sv, 0, "a BMP image", kConvert},
    {"WEBP"sv, 8, "a WebP image", kConvert},
    {"\x76\x2f\x31\x01"sv, 0, "an OpenEXR image", "convert depth to 16-bit PNG in millimetres"},
    {"\x93NUMPY"sv, 0, "a NumPy array",
     "write depth as 16-bit PNG in millimetres, for example with cv2.imwrite"},
    {"ftyp"sv, 4, "a HEIC, AVIF or video file",
     "convert it to PNG or JPEG first; extract the frames of a video"},
    {"\x00\x00\x00\x0cjP"sv, 0, "a JPEG 2000 image", kConvert},
    {"\xff\x0a"sv, 0, "a JPEG XL image", kConvert},
    {"P7\n"sv, 0, "a PAM image", kConvert},
    {"II+\0"sv, 0, "a BigTIFF image", "convert it to PNG"},
    {"MM\0+"sv, 0, "a BigTIFF image", "convert it to PNG"},
    {"\x89HDF"sv, 0, "an HDF5 or MATLAB file", "export its images as PNG"},
    {"MATLAB "sv, 0, "a MATLAB file", "export its images as PNG"},
    {"\x1f\x8b"sv, 0, "a gzip archive", "unpack it first"},
    {"PK\x03\x04"sv, 0, "a zip archive", "unpack it first"},
    {"version https://git-lfs"sv, 0, "a Git LFS pointer, not the image", "run git lfs pull"},
    {"<"sv, 0, "a web page or SVG, not an image", "download the image again"},
};

Result<PictureHeader> png_header(Bytes bytes) {
  if (bytes.size() < 33 || !begins_with(bytes, "IHDR", 12)) return broken();
  PictureHeader header;
  header.format = Format::kPng;
  const std::uint32_t width = big_endian(bytes, 16, 4), height = big_endian(bytes, 20, 4);
  if (width > 0x7fffffff || height > 0x7fffffff) return broken();
  header.width = static_cast<int>(width);
  header.height = static_cast<int>(height);
  header.bits = std::max<int>(bytes[24], 8);
  constexpr std::array<int, 7> kChannels{1, 0, 3, 3, 2, 0, 4};
  if (bytes[25] >= kChannels.size() || kChannels[bytes[25]] == 0) return broken();
  header.channels = kChannels[bytes[25]];
  header.is_palette = bytes[25] == 3;
  return header;
}

// Reads a number of `count` bytes at `at` in the byte order of a TIFF file. Returns 0 past the end.
std::uint32_t tiff_number(Bytes tiff, std::size_t at, std::size_t count, bool is_big_endian) {
  if (at > tiff.size() || tiff.size() - at < count) return 0;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value |= std::uint32_t{tiff[at + i]} << 8 * (is_big_endian ? count - 1 - i : i);
  }
  return value;
}

// Reads the orientation from the first directory of an EXIF block, which is a TIFF file.
int exif_orientation(Bytes segment) {
  if (segment.size() < 14 || !begins_with(segment, "Exif\0\0"sv)) return 1;
  const Bytes tiff = segment.subspan(6);
  const bool is_big_endian = tiff[0] == 'M';
  const std::size_t directory = tiff_number(tiff, 4, 4, is_big_endian);
  const std::uint32_t entries = tiff_number(tiff, directory, 2, is_big_endian);
  constexpr std::uint32_t kOrientation = 0x0112;
  for (std::uint32_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + std::size_t{12} * i;
    if (entry + 12 > tiff.size()) break;
    if (tiff_number(tiff, entry, 2, is_big_endian) != kOrientation) continue;
    const std::uint32_t orientation = tiff_number(tiff, entry + 8, 2, is_big_endian);
    return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  }
  return 1;
}

Result<PictureHeader> jpeg_header(const ReadAt& read_at) {
  int orientation = 1;
  std::uint64_t at = 2;
  for (int segments = 0; segments < 10'000; ++segments) {
    std::array<std::uint8_t, 10> bytes{};
    if (read_at(at, std::span(bytes).first(4)) < 4 || bytes[0] != 0xFF) return broken();
    const std::uint8_t marker = bytes[1];
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {  // Skips a marker without length.
      at += 2;
      continue;
    }
    const bool is_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (!is_frame) {
      if (marker == 0xD9 || marker == 0xDA) return broken();
      const std::uint32_t length = big_endian(bytes, 2, 2);
      if (marker == 0xE1 && length > 2) {
        std::vector<std::uint8_t> segment(length - 2);
        segment.resize(read_at(at + 4, segment));
        orientation = std::max(orientation, exif_orientation(segment));
      }
      at += 2 + length;
      continue;
    }
    if (read_at(at, bytes) < bytes.size()) return broken();
    PictureHeader header;
    header.format = Format::kJpeg;
    header.bits = bytes[4];
    header.height = static_cast<int>(big_endian(bytes, 5, 2));
    header.width = static_cast<int>(big_endian(bytes, 7, 2));
    header.channels = bytes[9];
    header.orientation = orientation;
    return header;
  }
  return broken();
}

// Reads the next number of a Netpbm or PFM header. White space separates numbers. A comment extends
// from # to the end of the line.
std::optional<double> next_number(Bytes bytes, std::size_t& at) {
  while (at < bytes.size() && (std::isspace(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  std::string text;
  while (at < bytes.size() && !std::isspace(bytes[at]) && text.size() < 32)
    text += static_cast<char>(bytes[at++]);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0) return std::nullopt;
  return value;
}

Result<PictureHeader> netpbm_header(Bytes bytes) {
  const bool is_pfm = bytes[1] == 'f' || bytes[1] == 'F';
  std::size_t at = 2;
  const auto width = next_number(bytes, at), height = next_number(bytes, at);
  const bool has_largest = bytes[1] != '1' && bytes[1] != '4';
  const auto largest = has_largest ? next_number(bytes, at) : std::optional(1.0);
  constexpr double kMost = 1e9;
  if (!width || !height || !largest || !(*width >= 0) || *width > kMost || !(*height >= 0) ||
      *height > kMost) {
    return broken();
  }
  PictureHeader header;
  header.format = is_pfm ? Format::kPfm : Format::kNetpbm;
  header.width = static_cast<int>(*width);
  header.height = static_cast<int>(*height);
  header.channels = bytes[1] == '3' || bytes[1] == '6' || bytes[1] == 'F' ? 3 : 1;
  header.bits = is_pfm ? 32 : *largest > 255 ? 16 : 8;
  header.is_float = is_pfm;
  return header;
}

Result<PictureHeader> tiff_header(const ReadAt& read_at, Bytes bytes) {
  const bool little = bytes[0] == 'I';
  const auto number = [little](Bytes from, std::size_t at, std::size_t count) {
    return tiff_number(from, at, count, !little);
  };
  const std::uint64_t directory = number(bytes, 4, 4);
  std::array<std::uint8_t, 12> entry{};
  if (read_at(directory, std::span(entry).first(2)) < 2) return broken();
  const std::uint32_t entries = number(entry, 0, 2);
  PictureHeader header;
  header.format = Format::kTiff;
  header.channels = 1;
  header.bits = 1;
  for (std::uint32_t i = 0; i < entries; ++i) {
    if (read_at(directory + 2 + 12ull * i, entry) < entry.size()) return broken();
    const std::uint32_t tag = number(entry, 0, 2), type = number(entry, 2, 2), count = number(entry, 4, 4);
    std::uint32_t value = number(entry, 8, type == 3 ? 2 : 4);
    if (type == 3 && count > 2) {  // The entry holds the offset of the values.
      std::array<std::uint8_t, 2> there{};
      if (read_at(number(entry, 8, 4), there) < 2) return broken();
      value = number(there, 0, 2);
    }
    if (value > 0x7fffffff) value = 0x7fffffff;
    const int whole = static_cast<int>(value);
    if (tag == 256) header.width = whole;
    if (tag == 257) header.height = whole;
    if (tag == 258) header.bits = whole;
    if (tag == 277) header.channels = whole;
    if (tag == 339) header.is_float = whole == 3;
  }
  return header;
}

Result<PictureHeader> header_of(const ReadAt& read_at) {
  std::array<std::uint8_t, kBeginning> beginning{};
  const Bytes bytes = Bytes(beginning).first(read_at(0, beginning));
  if (bytes.empty()) return fail(ErrorCode::kCorrupt, "the file is empty; use another copy");
  if (begins_with(bytes, "\x89PNG\r\n\x1a\n")) return png_header(bytes);
  if (begins_with(bytes, "\xff\xd8")) return jpeg_header(read_at);
  if (begins_with(bytes, "II*\0"sv) || begins_with(bytes, "MM\0*"sv)) {
    return bytes.size() < 8 ? broken() : tiff_header(read_at, bytes);
  }
  const bool is_p = bytes.size() > 3 && bytes[0] == 'P' && std::isspace(bytes[2]);
  if (is_p && ((bytes[1] >= '1' && bytes[1] <= '6') || bytes[1] == 'f' || bytes[1] == 'F')) {
    return netpbm_header(bytes);
  }
  for (const ForeignFormat& format : kForeignFormats) {
    if (begins_with(bytes, format.begin, format.at)) {
      return fail(ErrorCode::kUnsupported,
                  fmt::format("{}, which is not supported; {}", format.name, format.remedy));
    }
  }
  return fail(
      ErrorCode::kCorrupt,
      "not an image that is read here (PNG, JPEG, PGM, PPM, TIFF, PFM), or damaged; use another copy");
}

tl::unexpected<Error> named(const std::filesystem::path& path, const Error& error) {
  return fail(error.code, fmt::format("{}: {}", path.string(), error.what));
}

}  // namespace

Result<PictureHeader> read_header(const ReadAt& read_at) {
  auto header = header_of(read_at);
  if (!header) return header;
  const bool sound = header->width > 0 && header->height > 0 && header->channels >= 1 &&
                     header->channels <= 4 && header->bits >= 1 && header->bits <= 64;
  if (!sound) return broken();
  return header;
}

Result<PictureHeader> read_header(const std::filesystem::path& path) {
  std::error_code problem;
  std::ifstream file;
  if (std::filesystem::is_regular_file(path, problem)) file.open(path, std::ios::binary);
  if (!file.is_open()) {
    return fail(
        ErrorCode::kNotFound,
        fmt::format("{}: cannot be read; check that it is there and that you may read it", path.string()));
  }
  const auto header = read_header([&](std::uint64_t offset, std::span<std::uint8_t> into) {
    file.clear();
    file.seekg(static_cast<std::streamoff>(offset));
    file.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()));
    return static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0));
  });
  if (!header) return named(path, header.error());
  return header;
}

Result<std::vector<std::uint8_t>> load(const std::filesystem::path& path, std::uint64_t most_pixels) {
  const auto header = read_header(path);
  if (!header) return fail(header.error());
  if (header->pixels() > most_pixels) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {}x{} pixels, more than the supported {} million; scale the image down",
                            path.string(), header->width, header->height, most_pixels / 1'000'000));
  }
  std::error_code problem;
  const std::uint64_t size = std::filesystem::file_size(path, problem);
  if (problem || size > kBytesPerPixel * most_pixels + kMetadataBytes) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: the file is too large for an image; check that it is one", path.string()));
  }
  std::vector<std::uint8_t> bytes(size);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

}  // namespace copresence::pictures
