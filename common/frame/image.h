#pragma once

// A width x height array of pixels in memory, row by row from the top, without padding. Thread: a
// value; distinct images are independent. A moved-from image is empty, 0 x 0.

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace copresence {

/// Allocator whose vectors leave new elements uninitialised in resize(). Zeroing a frame that is
/// about to be overwritten costs as much as writing it.
template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {  // NOLINT(readability-identifier-naming): the standard library requires this name
    using other = UninitialisedAllocator<U>;
  };
  template <class U>
  void construct(U* at) {
    if constexpr (!std::is_trivially_copyable_v<U>) std::construct_at(at);
  }
  template <class U, class... From>
  void construct(U* at, From&&... from) {
    std::construct_at(at, std::forward<From>(from)...);
  }
};

template <class Pixel>
class Image {
 public:
  Image() = default;
  Image(const Image& other) { *this = other; }
  Image(Image&& other) noexcept
      : width_(std::exchange(other.width_, 0)),
        height_(std::exchange(other.height_, 0)),
        pixels_(std::move(other.pixels_)) {}
  Image& operator=(Image&& other) noexcept {
    Image taken(std::move(other));
    std::swap(width_, taken.width_);
    std::swap(height_, taken.height_);
    pixels_.swap(taken.pixels_);
    return *this;
  }
  ~Image() = default;

  // Copies all pixels as one block. A vector's own assignment constructs each pixel separately,
  // which takes five times as long for Rgb8.
  Image& operator=(const Image& other) {
    width_ = other.width_;
    height_ = other.height_;
    pixels_.resize(other.pixels_.size());
    std::copy(other.pixels_.begin(), other.pixels_.end(), pixels_.begin());
    return *this;
  }

  Image(int width, int height, Pixel fill = Pixel{})
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * height, fill) {
    assert(width >= 0 && height >= 0);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return pixels_.empty(); }

  /// Requires 0 <= x < width(), 0 <= y < height().
  Pixel& operator()(int x, int y) { return pixels_[index(x, y)]; }
  const Pixel& operator()(int x, int y) const { return pixels_[index(x, y)]; }

  std::span<Pixel> row(int y) { return {pixels_.data() + index(0, y), static_cast<std::size_t>(width_)}; }
  std::span<const Pixel> row(int y) const {
    return {pixels_.data() + index(0, y), static_cast<std::size_t>(width_)};
  }

  std::span<Pixel> pixels() { return pixels_; }
  std::span<const Pixel> pixels() const { return pixels_; }
  Pixel* data() { return pixels_.data(); }
  const Pixel* data() const { return pixels_.data(); }

  /// Changes the shape. Pixel values are unspecified afterwards. Reuses the memory if it is large
  /// enough.
  void resize(int width, int height) {
    assert(width >= 0 && height >= 0);
    width_ = width;
    height_ = height;
    pixels_.resize(static_cast<std::size_t>(width) * height);
  }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  std::size_t index(int x, int y) const {
    assert(x >= 0 && x < width_ && y >= 0 && y < height_);
    return static_cast<std::size_t>(y) * width_ + x;
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<Pixel, UninitialisedAllocator<Pixel>> pixels_;
};

template <class A, class B>
bool same_shape(const Image<A>& a, const Image<B>& b) {
  return a.width() == b.width() && a.height() == b.height();
}

struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};
static_assert(sizeof(Rgb8) == 3);

struct Rgba8 {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;
  friend bool operator==(const Rgba8&, const Rgba8&) = default;
};
static_assert(sizeof(Rgba8) == 4);

/// Says if a pixel's depth is missing, measured or guessed. The coded validity mask uses the same
/// numbers.
enum class DepthState : std::uint8_t {
  kHole = 0,      ///< No depth; the depth image holds 0 there.
  kMeasured = 1,  ///< The sensor's own value, unchanged.
  kFilled = 2,    ///< Depth from hole filling.
};

using DepthImage = Image<std::uint16_t>;  ///< Along the optical axis in the stream's DepthUnit; 0 = none.
using StateImage = Image<DepthState>;
using ColorImage = Image<Rgb8>;

}  // namespace copresence
