#include "common/gl/framebuffer.h"

#include <epoxy/gl.h>

#include <cassert>

#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/program.h"
#include "common/gl/texture.h"

namespace copresence::gl {

Framebuffer::Framebuffer(Context& context, std::initializer_list<const Texture*> colors, const Texture* depth,
                         int layer)
    : vertex_array_(context.vertex_array_.id()), has_depth_(depth != nullptr) {
  assert(context.is_on_its_thread() && (depth || colors.size() > 0));
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  name_ = Name<delete_framebuffer>(id);
  const auto attach = [&](GLenum where, const Texture& texture) {
    assert(width_ == 0 || (texture.width() == width_ && texture.height() == height_));
    width_ = texture.width();
    height_ = texture.height();
    if (texture.layers()) {
      glNamedFramebufferTextureLayer(id, where, texture.id(), 0, layer);
    } else {
      glNamedFramebufferTexture(id, where, texture.id(), 0);
    }
  };
  std::array<GLenum, 8> targets{};
  GLsizei count = 0;
  for (const Texture* color : colors) {
    targets[count] = GLenum(GL_COLOR_ATTACHMENT0 + count);
    attach(targets[count++], *color);
  }
  if (depth) attach(GL_DEPTH_ATTACHMENT, *depth);
  glNamedFramebufferDrawBuffers(id, count, targets.data());
  // Every OpenGL 4.5 driver must support drawing into all formats of Format.
  assert(glCheckNamedFramebufferStatus(id, GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
}

void Framebuffer::clear_color(int attachment, const std::array<float, 4>& value) {
  glClearNamedFramebufferfv(name_.id(), GL_COLOR, attachment, value.data());
}

void Framebuffer::clear_integers(int attachment, const std::array<std::uint32_t, 4>& value) {
  glClearNamedFramebufferuiv(name_.id(), GL_COLOR, attachment, value.data());
}

void Framebuffer::clear_depth(float value) {
  glClearNamedFramebufferfv(name_.id(), GL_DEPTH, 0, &value);
}

void Framebuffer::begin(const Program& program) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, name_.id());
  glViewport(0, 0, width_, height_);
  (has_depth_ ? glEnable : glDisable)(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  glPolygonMode(GL_FRONT_AND_BACK, draws_lines_ ? GL_LINE : GL_FILL);
  glUseProgram(program.id());
}

void Framebuffer::draw_indirect(const Program& program, const Buffer& indices, const Buffer& command,
                                std::size_t offset) {
  begin(program);
  glVertexArrayElementBuffer(vertex_array_, indices.id());
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, command.id());
  glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset));
}

void Framebuffer::draw(const Program& program, int vertices) {
  begin(program);
  glDrawArrays(GL_TRIANGLES, 0, vertices);
}

}  // namespace copresence::gl
