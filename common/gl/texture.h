#pragma once

// A picture on the graphics card, or a stack of equal ones. Size and format never change. Rows run from the
// top, as in Image: row 0 is v = 0.

#include <cstddef>
#include <cstdint>

#include "common/frame/image.h"
#include "common/gl/name.h"

namespace copresence::gl {

class Context;

enum class Format : std::uint8_t { kR8ui, kR16ui, kR32ui, kR32f, kRg32f, kRgba32f, kRgba8, kDepth32f };

/// Of one pixel as read() and upload() see it.
int bytes_per_pixel(Format format);

enum class Filter : bool { kNearest, kLinear };
enum class Access : std::uint8_t { kRead, kWrite, kReadWrite };

class Texture {
 public:
  /// Requires width, height > 0 (at most 16384 everywhere). `layers` > 0 makes a stack (sampler2DArray,
  /// image2DArray), 0 a single picture. The pixels are 0; lookups outside repeat the edge.
  Texture(Context& context, Format format, int width, int height, int layers = 0);

  Format format() const { return format_; }
  int width() const { return width_; }
  int height() const { return height_; }
  int layers() const { return layers_; }
  std::uint32_t id() const { return name_.id(); }

  /// Copies an image in. Requires the texture's size and pixels of bytes_per_pixel().
  template <class Pixel>
  void upload(const Image<Pixel>& image, int layer = 0) {
    upload_pixels(image.data(), image.width(), image.height(), sizeof(Pixel), layer);
  }

  /// Colour into a kRgba8 texture, with a = 255. Widened here, because drivers take ten times longer for it.
  void upload(const ColorImage& image, int layer = 0);

  /// Copies the picture out; `image` gets its size. Waits until the commands before it are done; a shader's
  /// writes need Context::barrier(Reader::kHost) before it.
  template <class Pixel>
  void read(Image<Pixel>& image, int layer = 0) const {
    image.resize(width_, height_);
    read_pixels(image.data(), sizeof(Pixel), layer);
  }

  /// Zeros everywhere.
  void clear();

  void set_filter(Filter filter);  ///< kNearest until said otherwise

  /// As the sampler `layout(binding = N)` of the shaders that run from here on.
  void bind(int unit) const;
  /// As the image `layout(binding = N)`, all layers.
  void bind_image(int unit, Access access) const;

 private:
  void upload_pixels(const void* pixels, int width, int height, std::size_t pixel_bytes, int layer);
  void read_pixels(void* pixels, std::size_t pixel_bytes, int layer) const;

  Name<delete_texture> name_;
  Format format_;
  int width_;
  int height_;
  int layers_;
  Image<Rgba8> widened_;  // keeps its memory from one upload to the next
};

}  // namespace copresence::gl
