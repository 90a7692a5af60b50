#pragma once

// What a video codec takes and gives: planes of 8-bit or 10-bit samples, full range, no padding.
//
// Thread: a value. The deleter of a lent picture's owner may run on any thread. A moved-from picture is empty.

#include <array>
#include <cassert>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace copresence {

enum class PixelFormat : std::uint8_t {
  kGray8 = 1,   ///< 4:0:0, 8 bit
  kGray10 = 2,  ///< 4:0:0, 10 bit, one sample in two bytes, host order
  kYuv420 = 3,  ///< 8 bit, chroma halved both ways
  kYuv444 = 4,  ///< 8 bit, chroma as large as luma
};

std::string_view name(PixelFormat format);  ///< gray8, gray10, yuv420, yuv444

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

  /// Samples are 0. Requires even sizes.
  Picture(PixelFormat format, int width, int height);
  /// The same with samples of any value, for who writes them all: zeros for a megabyte are time, too.
  static Picture unwritten(PixelFormat format, int width, int height);
  /// A picture whose samples lie with somebody else, where they are read while `owner` lives: a megabyte is not copied. Whoever
  /// writes to it gets a copy first.
  static Picture lent(PixelFormat format, int width, int height,
                      const std::array<const std::uint8_t*, 3>& planes, std::shared_ptr<const void> owner);

  PixelFormat format() const { return format_; }
  int width() const { return width_; }  ///< of luma
  int height() const { return height_; }
  int planes() const { return format_ == PixelFormat::kGray8 || format_ == PixelFormat::kGray10 ? 1 : 3; }
  int plane_width(int plane) const { return plane && format_ == PixelFormat::kYuv420 ? width_ / 2 : width_; }
  int plane_height(int plane) const {
    return plane && format_ == PixelFormat::kYuv420 ? height_ / 2 : height_;
  }
  int bytes_per_sample() const { return format_ == PixelFormat::kGray10 ? 2 : 1; }
  bool empty() const { return width_ == 0; }

  /// One plane's samples, row by row. plane8 Requires an 8-bit format, plane10 kGray10.
  std::span<std::uint8_t> plane8(int plane) { return plane_of<std::uint8_t>(*this, plane); }
  std::span<const std::uint8_t> plane8(int plane) const { return plane_of<const std::uint8_t>(*this, plane); }
  std::span<std::uint16_t> plane10() { return plane_of<std::uint16_t>(*this, 0); }
  std::span<const std::uint16_t> plane10() const { return plane_of<const std::uint16_t>(*this, 0); }

  /// The same format, size and samples.
  friend bool operator==(const Picture& a, const Picture& b);

 private:
  template <class Sample, class Self>
  static std::span<Sample> plane_of(Self& self, int plane) {
    assert(plane >= 0 && plane < self.planes() && int(sizeof(Sample)) == self.bytes_per_sample());
    return {reinterpret_cast<Sample*>(self.first_sample(plane)),
            static_cast<std::size_t>(self.plane_width(plane)) * self.plane_height(plane)};
  }
  const std::uint8_t* first_sample(int plane) const {
    return owner_ ? lent_[plane] : samples_.data() + plane_offset(plane);
  }
  std::uint8_t* first_sample(int plane) {
    if (owner_) own();
    return samples_.data() + plane_offset(plane);
  }
  std::size_t plane_bytes(int plane) const {
    return static_cast<std::size_t>(plane_width(plane)) * plane_height(plane) * bytes_per_sample();
  }
  std::size_t plane_offset(int plane) const;
  void own();
  void swap(Picture& other) noexcept {
    std::swap(format_, other.format_);
    std::swap(width_, other.width_);
    std::swap(height_, other.height_);
    samples_.swap(other.samples_);
    std::swap(lent_, other.lent_);
    owner_.swap(other.owner_);
  }

  PixelFormat format_ = PixelFormat::kGray8;
  int width_ = 0;
  int height_ = 0;
  // Leaves new samples as they are where it is not told their value.
  struct Uninitialised : std::allocator<std::uint8_t> {
    template <class T>
    struct rebind {  // NOLINT(readability-identifier-naming): the standard library asks for this name
      using other = Uninitialised;
    };
    void construct(std::uint8_t* sample) { ::new (static_cast<void*>(sample)) std::uint8_t; }
    void construct(std::uint8_t* sample, std::uint8_t value) { *sample = value; }
  };

  std::vector<std::uint8_t, Uninitialised>
      samples_;  // all planes, one after the other; new[] aligns them for 16 bits; none where they are lent
  std::array<const std::uint8_t*, 3> lent_{};
  std::shared_ptr<const void> owner_;
};

}  // namespace copresence
