#pragma once

// The key of a room: 32 random bytes that all servers and viewers of the room share. Whoever has
// the key can watch the room.
//
// A key file is text: lines that begin with `#`, and one line of 64 hexadecimal digits. Only the
// file's owner may be able to read it. No error message contains text from a key file. Thread:
// distinct objects are independent.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/result.h"

namespace copresence::tls {

class RoomKey {
 public:
  static constexpr std::size_t kBytes = 32;

  explicit RoomKey(const std::array<std::uint8_t, kBytes>& bytes) : bytes_(bytes) {}
  RoomKey(const RoomKey&) = default;
  RoomKey& operator=(const RoomKey&) = default;
  /// Overwrites the bytes in memory.
  ~RoomKey();

  std::span<const std::uint8_t, kBytes> bytes() const { return bytes_; }
  friend bool operator==(const RoomKey&, const RoomKey&) = default;

 private:
  std::array<std::uint8_t, kBytes> bytes_;
};

/// Reads a key file. Fails with kNotFound if there is none, with kUnavailable if it cannot be read.
/// Fails with kInvalid if other users can read the file, or if it is not a key file.
Result<RoomKey> read_key(const std::filesystem::path& path);

/// Reads the text of a key file. `path` is used in error messages. Fails with kInvalid.
Result<RoomKey> parse_key(std::string_view text, const std::filesystem::path& path);

/// Writes a new random key to `path`, readable by the owner only. Never overwrites: fails with
/// kInvalid if the file exists. Fails with kUnavailable if it cannot be written.
Result<void> make_key(const std::filesystem::path& path);

}  // namespace copresence::tls
