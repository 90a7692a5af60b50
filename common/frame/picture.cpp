#include "common/frame/picture.h"

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

Picture::Picture(PixelFormat format, int width, int height)
    : format_(format), width_(width), height_(height) {
  assert(width >= 0 && height >= 0 && width % 2 == 0 && height % 2 == 0);
  samples_.resize(plane_offset(planes()));
}

std::size_t Picture::plane_offset(int plane) const {
  std::size_t offset = 0;
  for (int i = 0; i < plane; ++i) {
    offset += static_cast<std::size_t>(plane_width(i)) * plane_height(i) * bytes_per_sample();
  }
  return offset;
}

}  // namespace copresence
