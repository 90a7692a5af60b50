#include "common/frame/picture.h"

#include <algorithm>
#include <cstring>
#include <utility>

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

Picture Picture::uninitialised(PixelFormat format, int width, int height) {
  assert(width >= 0 && height >= 0 && width % 2 == 0 && height % 2 == 0);
  Picture picture;
  picture.format_ = format;
  picture.width_ = width;
  picture.height_ = height;
  picture.samples_.resize(picture.plane_offset(picture.planes()));
  return picture;
}

Picture::Picture(PixelFormat format, int width, int height) : Picture(uninitialised(format, width, height)) {
  std::fill(samples_.begin(), samples_.end(), std::uint8_t{0});
}

std::size_t Picture::plane_offset(int plane) const {
  std::size_t offset = 0;
  for (int i = 0; i < plane; ++i) offset += plane_bytes(i);
  return offset;
}

Picture Picture::borrowed(PixelFormat format, int width, int height,
                          const std::array<const std::uint8_t*, 3>& planes,
                          std::shared_ptr<const void> owner) {
  assert(owner && width >= 0 && height >= 0 && width % 2 == 0 && height % 2 == 0);
  Picture picture;
  picture.format_ = format;
  picture.width_ = width;
  picture.height_ = height;
  picture.borrowed_ = planes;
  picture.owner_ = std::move(owner);
  return picture;
}

void Picture::copy_borrowed() {
  samples_.resize(plane_offset(planes()));
  for (int i = 0; i < planes(); ++i)
    std::memcpy(samples_.data() + plane_offset(i), borrowed_[i], plane_bytes(i));
  owner_.reset();
}

bool operator==(const Picture& a, const Picture& b) {
  if (a.format_ != b.format_ || a.width_ != b.width_ || a.height_ != b.height_) return false;
  for (int i = 0; i < a.planes(); ++i) {
    const std::uint8_t* const first = a.first_sample(i);
    if (!std::equal(first, first + a.plane_bytes(i), b.first_sample(i))) return false;
  }
  return true;
}

}  // namespace copresence
