#include "render_client/display/screenshot.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <fstream>
#include <vector>

namespace copresence::display {

Result<void> write_png(const std::string& path, const Image<Rgba8>& image) {
  const bool is_opaque = std::all_of(image.pixels().begin(), image.pixels().end(),
                                     [](const Rgba8& pixel) { return pixel.a == 255; });
  std::vector<std::uint8_t> rgb;
  if (is_opaque) {
    rgb.reserve(3 * image.pixels().size());
    for (const Rgba8& pixel : image.pixels()) rgb.insert(rgb.end(), {pixel.r, pixel.g, pixel.b});
  }
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width());
  header.height = static_cast<png_uint_32>(image.height());
  header.format = is_opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  header.flags = PNG_IMAGE_FLAG_FAST;  // Fast compression, since the user waits for the file.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<char> png(size);
  const void* const pixels = is_opaque ? static_cast<const void*>(rgb.data()) : image.data();
  if (!png_image_write_to_memory(&header, png.data(), &size, 0, pixels, 0, nullptr))
    return fail(ErrorCode::kUnavailable, fmt::format("{}: {}", path, header.message));
  std::ofstream file(path, std::ios::binary);
  file.write(png.data(), static_cast<std::streamsize>(size));
  file.flush();
  if (!file)
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the picture cannot be written there", path));
  return {};
}

}  // namespace copresence::display
