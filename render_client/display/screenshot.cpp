#include "render_client/display/screenshot.h"

#include <fmt/format.h>
#include <png.h>

#include <fstream>
#include <vector>

namespace copresence::display {

Result<void> write_png(const std::string& path, const Image<Rgba8>& image) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * image.pixels().size());
  for (const Rgba8& pixel : image.pixels()) rgb.insert(rgb.end(), {pixel.r, pixel.g, pixel.b});
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width());
  header.height = static_cast<png_uint_32>(image.height());
  header.format = PNG_FORMAT_RGB;
  header.flags = PNG_IMAGE_FLAG_FAST;  // Fast compression, since the user waits for the file.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<char> png(size);
  if (!png_image_write_to_memory(&header, png.data(), &size, 0, rgb.data(), 0, nullptr))
    return fail(ErrorCode::kUnavailable, fmt::format("{}: {}", path, header.message));
  std::ofstream file(path, std::ios::binary);
  file.write(png.data(), static_cast<std::streamsize>(size));
  file.flush();
  if (!file)
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the picture cannot be written there", path));
  return {};
}

}  // namespace copresence::display
