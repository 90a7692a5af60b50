#pragma once

// A picture in graphics memory, or an array of pictures (layers). Size and format are constant. Row
// 0 is the top row, as in Image, and has v = 0. Thread: only the thread of its context (context.h).

#include <cstddef>
#include <cstdint>

#include "common/frame/image.h"
#include "common/gl/name.h"

namespace copresence::gl {

class Context;

enum class Format : std::uint8_t { kR8ui, kR16ui, kR32ui, kR32f, kRg32f, kRgba32f, kRgba8, kDepth32f };

/// Size of one pixel in bytes, for read() and upload().
int bytes_per_pixel(Format format);

enum class Filter : bool { kNearest, kLinear };
enum class Access : std::uint8_t { kRead, kWrite, kReadWrite };

class Texture {
 public:
  /// Creates an array (sampler2DArray, image2DArray) if layers > 0, otherwise a single picture.
  /// Requires width and height from 1 to 16384. All pixels are 0. Samples outside the picture
  /// repeat its edge.
  Texture(Context& context, Format format, int width, int height, int layers = 0);

  Format format() const { return format_; }
  int width() const { return width_; }
  int height() const { return height_; }
  int layers() const { return layers_; }
  std::uint32_t id() const { return name_.id(); }

  /// Copies an image into the texture. Requires equal sizes and pixels of bytes_per_pixel().
  template <class Pixel>
  void upload(const Image<Pixel>& image, int layer = 0) {
    upload_pixels(image.data(), image.width(), image.height(), sizeof(Pixel), layer);
  }

  /// Copies RGB into a kRgba8 texture with alpha 255. Drivers would convert ten times slower.
  void upload(const ColorImage& image, int layer = 0);

  /// Copies the texture into `image` and resizes it to fit. Waits for all earlier commands. Before
  /// you read what a shader wrote, call Context::barrier(Reader::kHost).
  template <class Pixel>
  void read(Image<Pixel>& image, int layer = 0) const {
    image.resize(width_, height_);
    read_pixels(image.data(), sizeof(Pixel), layer);
  }

  void clear();

  void set_filter(Filter filter);  ///< Initially kNearest.

  /// Binds the texture as the sampler `layout(binding = N)` of shaders that run later.
  void bind(int unit) const;
  /// Binds all layers as the image `layout(binding = N)`.
  void bind_image(int unit, Access access) const;

 private:
  void upload_pixels(const void* pixels, int width, int height, std::size_t pixel_bytes, int layer);
  void read_pixels(void* pixels, std::size_t pixel_bytes, int layer) const;

  Name<delete_texture> name_;
  Format format_;
  int width_;
  int height_;
  int layers_;
  Image<Rgba8> widened_;  // Converted pixels; a member, so that the memory is reused.
};

}  // namespace copresence::gl
