#pragma once

// A block of graphics memory of constant size, for storage blocks, indices and indirect commands.
// Thread: only the thread of its context (context.h).

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/gl/name.h"

namespace copresence::gl {

class Context;

class Buffer {
 public:
  /// Allocates memory that is filled with zeros. Requires bytes > 0.
  Buffer(Context& context, std::size_t bytes);

  std::size_t bytes() const { return bytes_; }
  std::uint32_t id() const { return name_.id(); }

  /// Copies values to or from the buffer, starting at byte `offset`. Requires that offset plus the
  /// span's size is at most bytes(). Reading waits for all earlier commands. Before you read what a
  /// shader wrote, call Context::barrier(Reader::kHost).
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

  void clear();

  /// Binds the buffer as the storage block `layout(std430, binding = N)` of shaders that run later.
  void bind_storage(int binding) const;

 private:
  void write_bytes(std::span<const std::byte> bytes, std::size_t offset);
  void read_bytes(std::span<std::byte> bytes, std::size_t offset) const;

  Name<delete_buffer> name_;
  std::size_t bytes_ = 0;
};

}  // namespace copresence::gl
