#include "common/frame/picture.h"

#include <algorithm>

namespace copresence {

std::string_view name(PixelFormat format) {
  switch (format) {
    case PixelFormat::kGray8:
      return "gray8";
    case PixelFormat::kGray10:
      return "gray10";
    case PixelFormat::kYuv420:
      return "yuv420";
    case PixelFormat::kYuv444:
      return "yuv444";
  }
  return "unknown";
}

Picture Picture::unwritten(PixelFormat format, int width, int height) {
  assert(width >= 0 && height >= 0 && width % 2 == 0 && height % 2 == 0);
  Picture picture;
  picture.format_ = format;
  picture.width_ = width;
  picture.height_ = height;
  picture.samples_.resize(picture.plane_offset(picture.planes()));
  return picture;
}

Picture::Picture(PixelFormat format, int width, int height) : Picture(unwritten(format, width, height)) {
  std::fill(samples_.begin(), samples_.end(), std::uint8_t{0});
}

std::size_t Picture::plane_offset(int plane) const {
  std::size_t offset = 0;
  for (int i = 0; i < plane; ++i) {
    offset += static_cast<std::size_t>(plane_width(i)) * plane_height(i) * bytes_per_sample();
  }
  return offset;
}

}  // namespace copresence
