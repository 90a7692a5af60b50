#include "common/gl/texture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>

#include "common/gl/context.h"

namespace copresence::gl {
namespace {

struct Layout {
  GLenum stored, components, type;
  int bytes;
};

Layout layout_of(Format format) {
  switch (format) {
    case Format::kR8ui:
      return {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1};
    case Format::kR16ui:
      return {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 2};
    case Format::kR32ui:
      return {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4};
    case Format::kR32f:
      return {GL_R32F, GL_RED, GL_FLOAT, 4};
    case Format::kRg32f:
      return {GL_RG32F, GL_RG, GL_FLOAT, 8};
    case Format::kRgba32f:
      return {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16};
    case Format::kRgba8:
      return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4};
    case Format::kDepth32f:
      return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4};
  }
  assert(false);
  return {};
}

GLenum access_of(Access access) {
  return access == Access::kRead ? GL_READ_ONLY : access == Access::kWrite ? GL_WRITE_ONLY : GL_READ_WRITE;
}

}  // namespace

int bytes_per_pixel(Format format) {
  return layout_of(format).bytes;
}

Texture::Texture([[maybe_unused]] Context& context, Format format, int width, int height, int layers)
    : format_(format), width_(width), height_(height), layers_(layers) {
  assert(context.is_on_its_thread() && width > 0 && height > 0 && layers >= 0);
  GLuint id = 0;
  glCreateTextures(layers ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, 1, &id);
  name_ = Name<delete_texture>(id);
  if (layers) {
    glTextureStorage3D(id, 1, layout_of(format).stored, width, height, layers);
  } else {
    glTextureStorage2D(id, 1, layout_of(format).stored, width, height);
  }
  set_filter(Filter::kNearest);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  clear();
}

void Texture::upload(const ColorImage& image, int layer) {
  widened_.resize(image.width(), image.height());
  std::transform(image.pixels().begin(), image.pixels().end(), widened_.pixels().begin(), [](Rgb8 color) {
    return Rgba8{color.r, color.g, color.b, 255};
  });
  upload(widened_, layer);
}

void Texture::clear() {
  const Layout layout = layout_of(format_);
  glClearTexImage(id(), 0, layout.components, layout.type, nullptr);
}

void Texture::set_filter(Filter filter) {
  const GLint value = filter == Filter::kLinear ? GL_LINEAR : GL_NEAREST;
  glTextureParameteri(id(), GL_TEXTURE_MIN_FILTER, value);
  glTextureParameteri(id(), GL_TEXTURE_MAG_FILTER, value);
}

void Texture::bind(int unit) const {
  glBindTextureUnit(GLuint(unit), id());
}

void Texture::bind_image(int unit, Access access) const {
  glBindImageTexture(GLuint(unit), id(), 0, GL_TRUE, 0, access_of(access), layout_of(format_).stored);
}

void Texture::upload_pixels(const void* pixels, int width, int height,
                            [[maybe_unused]] std::size_t pixel_bytes, int layer) {
  const Layout layout = layout_of(format_);
  assert(width == width_ && height == height_ && pixel_bytes == std::size_t(layout.bytes));
  assert(layer >= 0 && layer < std::max(1, layers_));
  if (layers_) {
    glTextureSubImage3D(id(), 0, 0, 0, layer, width, height, 1, layout.components, layout.type, pixels);
  } else {
    glTextureSubImage2D(id(), 0, 0, 0, width, height, layout.components, layout.type, pixels);
  }
}

void Texture::read_pixels(void* pixels, [[maybe_unused]] std::size_t pixel_bytes, int layer) const {
  const Layout layout = layout_of(format_);
  assert(pixel_bytes == std::size_t(layout.bytes) && layer >= 0 && layer < std::max(1, layers_));
  glGetTextureSubImage(id(), 0, 0, 0, layer, width_, height_, 1, layout.components, layout.type,
                       width_ * height_ * layout.bytes, pixels);
}

}  // namespace copresence::gl
