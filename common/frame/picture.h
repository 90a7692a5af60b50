#pragma once

// A picture for a video codec: planes of 8-bit or 10-bit samples, full range, no padding. Thread: a
// value. The deleter of a borrowed picture's owner may run on any thread. A moved-from picture is
// empty.

#include <array>
#include <cassert>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "common/frame/image.h"

namespace copresence {

enum class PixelFormat : std::uint8_t {
  kGray8 = 1,   ///< Luma only (4:0:0), 8 bits per sample.
  kGray10 = 2,  ///< Luma only (4:0:0), 10 bits in two bytes, host order.
  kYuv420 = 3,  ///< Samples of 8 bits; chroma has half the width and height.
  kYuv444 = 4,  ///< Samples of 8 bits; chroma is as large as luma.
};

std::string_view name(PixelFormat format);  ///< Returns gray8, gray10, yuv420 or yuv444.

class Picture {
 public:
  Picture() = default;
  Picture(const Picture&) = default;
  Picture& operator=(const Picture&) = default;
  Picture(Picture&& other) noexcept { swap(other); }
  Picture& operator=(Picture&& other) noexcept {
    Picture taken(std::move(other));
    swap(taken);
    return *this;
  }
  ~Picture() = default;

  /// Creates a picture whose samples are 0. Requires even sizes.
  Picture(PixelFormat format, int width, int height);
  /// Like the constructor, but the samples are uninitialised. Use this if every sample will be
  /// written.
  static Picture uninitialised(PixelFormat format, int width, int height);
  /// Wraps planes owned by someone else without copying them, while `owner` keeps them alive. The
  /// first mutable access copies the planes.
  static Picture borrowed(PixelFormat format, int width, int height,
                          const std::array<const std::uint8_t*, 3>& planes,
                          std::shared_ptr<const void> owner);

  PixelFormat format() const { return format_; }
  int width() const { return width_; }  ///< Width of the luma plane.
  int height() const { return height_; }
  int planes() const { return format_ == PixelFormat::kGray8 || format_ == PixelFormat::kGray10 ? 1 : 3; }
  int plane_width(int plane) const { return plane && format_ == PixelFormat::kYuv420 ? width_ / 2 : width_; }
  int plane_height(int plane) const {
    return plane && format_ == PixelFormat::kYuv420 ? height_ / 2 : height_;
  }
  int bytes_per_sample() const { return format_ == PixelFormat::kGray10 ? 2 : 1; }
  bool empty() const { return width_ == 0; }

  /// Samples of one plane, row by row. plane8() requires an 8-bit format, plane10() requires
  /// kGray10.
  std::span<std::uint8_t> plane8(int plane) { return plane_of<std::uint8_t>(*this, plane); }
  std::span<const std::uint8_t> plane8(int plane) const { return plane_of<const std::uint8_t>(*this, plane); }
  std::span<std::uint16_t> plane10() { return plane_of<std::uint16_t>(*this, 0); }
  std::span<const std::uint16_t> plane10() const { return plane_of<const std::uint16_t>(*this, 0); }

  friend bool operator==(const Picture& a, const Picture& b);

 private:
  template <class Sample, class Self>
  static std::span<Sample> plane_of(Self& self, int plane) {
    assert(plane >= 0 && plane < self.planes() && int(sizeof(Sample)) == self.bytes_per_sample());
    return {reinterpret_cast<Sample*>(self.first_sample(plane)),
            static_cast<std::size_t>(self.plane_width(plane)) * self.plane_height(plane)};
  }
  const std::uint8_t* first_sample(int plane) const {
    return owner_ ? borrowed_[plane] : samples_.data() + plane_offset(plane);
  }
  std::uint8_t* first_sample(int plane) {
    if (owner_) copy_borrowed();
    return samples_.data() + plane_offset(plane);
  }
  std::size_t plane_bytes(int plane) const {
    return static_cast<std::size_t>(plane_width(plane)) * plane_height(plane) * bytes_per_sample();
  }
  std::size_t plane_offset(int plane) const;
  void copy_borrowed();
  void swap(Picture& other) noexcept {
    std::swap(format_, other.format_);
    std::swap(width_, other.width_);
    std::swap(height_, other.height_);
    samples_.swap(other.samples_);
    std::swap(borrowed_, other.borrowed_);
    owner_.swap(other.owner_);
  }

  PixelFormat format_ = PixelFormat::kGray8;
  int width_ = 0;
  int height_ = 0;
  // All planes, one after the other, aligned for 16-bit samples. Empty while the planes are
  // borrowed.
  std::vector<std::uint8_t, UninitialisedAllocator<std::uint8_t>> samples_;
  std::array<const std::uint8_t*, 3> borrowed_{};
  std::shared_ptr<const void> owner_;
};

}  // namespace copresence
