#pragma once

// A seal over the bytes that must arrive exactly: four bytes at the end of the state mask, a CRC-32 of the
// table, the samples and the mask, continued from the frame before. So a changed, shortened or missing byte shows, and so
// does a frame that was lost, repeated or put in another order; only a keyframe begins a new chain.
//
// Thread: a value.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace copresence::depth {

class ChainedChecksum {
 public:
  static constexpr std::size_t kBytes = 4;

  /// Appends the seal of `table`, `samples` and `mask` to `mask`.
  void close(bool keyframe, std::span<const std::uint8_t> table, std::span<const std::uint8_t> samples,
             std::vector<std::uint8_t>& mask);

  /// `mask` without its seal; nothing where the seal is not the one expected. From then on everything up to
  /// the next keyframe fails.
  std::optional<std::span<const std::uint8_t>> open(bool keyframe, std::span<const std::uint8_t> table,
                                                    std::span<const std::uint8_t> samples,
                                                    std::span<const std::uint8_t> mask);

  /// Everything up to the next keyframe fails.
  void break_chain() { chain_.reset(); }

 private:
  std::optional<std::uint32_t> chain_;  // the last good seal
};

}  // namespace copresence::depth
