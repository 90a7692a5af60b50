#include "common/gl/canvas.h"

#include <epoxy/gl.h>

#include <array>

namespace copresence::gl {

Canvas::Canvas(Context& context, int width, int height) : texture_(context, Format::kRgba8, width, height) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  framebuffer_ = Name<delete_framebuffer>(id);
  glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, texture_.id(), 0);
}

void Canvas::begin() {
  constexpr std::array<float, 4> kNothing{};
  glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, kNothing.data());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
}

void Canvas::copy(int left, int bottom, int width, int height, std::uint32_t framebuffer) const {
  const int right = left + width, top = bottom + height;
  glBlitNamedFramebuffer(framebuffer_.id(), framebuffer, left, bottom, right, top, left, bottom, right, top,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace copresence::gl
