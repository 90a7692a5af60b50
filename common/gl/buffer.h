#pragma once

// Memory of the graphics card: storage blocks, indices, indirect commands. Its size never changes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/gl/name.h"

namespace copresence::gl {

class Context;

class Buffer {
 public:
  /// `bytes` > 0, filled with zeros.
  Buffer(Context& context, std::size_t bytes);

  std::size_t bytes() const { return bytes_; }
  std::uint32_t id() const { return name_.id(); }

  /// Copies in and out from byte `offset` on. Requires offset + the span's bytes <= bytes(). read() waits
  /// until the commands before it are done; a shader's writes need Context::barrier(Reader::kHost) before it.
  template <class T, std::size_t N>
  void write(std::span<const T, N> values, std::size_t offset = 0) {
    static_assert(std::is_trivially_copyable_v<T>);
    write_bytes(std::as_bytes(values), offset);
  }
  template <class T, std::size_t N>
  void read(std::span<T, N> values, std::size_t offset = 0) const {
    static_assert(std::is_trivially_copyable_v<T>);
    read_bytes(std::as_writable_bytes(values), offset);
  }

  /// Zeros everywhere.
  void clear();

  /// As the storage block `layout(std430, binding = N)` of the shaders that run from here on.
  void bind_storage(int binding) const;

 private:
  void write_bytes(std::span<const std::byte> bytes, std::size_t offset);
  void read_bytes(std::span<std::byte> bytes, std::size_t offset) const;

  Name<delete_buffer> name_;
  std::size_t bytes_ = 0;
};

}  // namespace copresence::gl
