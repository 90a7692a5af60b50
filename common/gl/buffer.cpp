#include "common/gl/buffer.h"

#include <epoxy/gl.h>

#include <cassert>

#include "common/gl/context.h"

namespace copresence::gl {

Buffer::Buffer([[maybe_unused]] Context& context, std::size_t bytes) : bytes_(bytes) {
  assert(context.is_on_its_thread() && bytes > 0);
  GLuint id = 0;
  glCreateBuffers(1, &id);
  name_ = Name<delete_buffer>(id);
  glNamedBufferStorage(id, GLsizeiptr(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  clear();
}

void Buffer::clear() {
  glClearNamedBufferData(id(), GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, nullptr);
}

void Buffer::bind_storage(int binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(binding), id());
}

void Buffer::write_bytes(std::span<const std::byte> bytes, std::size_t offset) {
  assert(offset <= bytes_ && bytes.size() <= bytes_ - offset);
  glNamedBufferSubData(id(), GLintptr(offset), GLsizeiptr(bytes.size()), bytes.data());
}

void Buffer::read_bytes(std::span<std::byte> bytes, std::size_t offset) const {
  assert(offset <= bytes_ && bytes.size() <= bytes_ - offset);
  glGetNamedBufferSubData(id(), GLintptr(offset), GLsizeiptr(bytes.size()), bytes.data());
}

}  // namespace copresence::gl
