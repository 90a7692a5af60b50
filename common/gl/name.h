#pragma once

// Owns one OpenGL name, the integer that identifies an object. A moved-from Name holds 0 and owns
// nothing. Thread: only the thread of its context (context.h). Destroy the object before its
// context.

#include <cstdint>
#include <utility>

namespace copresence::gl {

using DeleteName = void(std::uint32_t id) noexcept;

DeleteName delete_buffer, delete_texture, delete_framebuffer, delete_program, delete_vertex_array;

template <DeleteName* kDelete>
class Name {
 public:
  Name() = default;
  explicit Name(std::uint32_t id) : id_(id) {}
  Name(Name&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Name& operator=(Name&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Name() {
    if (id_) kDelete(id_);
  }

  std::uint32_t id() const { return id_; }

 private:
  std::uint32_t id_ = 0;
};

}  // namespace copresence::gl
