#include "common/gl/name.h"

#include <epoxy/gl.h>

namespace copresence::gl {

void delete_buffer(std::uint32_t id) noexcept {
  glDeleteBuffers(1, &id);
}

void delete_texture(std::uint32_t id) noexcept {
  glDeleteTextures(1, &id);
}

void delete_framebuffer(std::uint32_t id) noexcept {
  glDeleteFramebuffers(1, &id);
}

void delete_program(std::uint32_t id) noexcept {
  glDeleteProgram(id);
}

void delete_vertex_array(std::uint32_t id) noexcept {
  glDeleteVertexArrays(1, &id);
}

}  // namespace copresence::gl
