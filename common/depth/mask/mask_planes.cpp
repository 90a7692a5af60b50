#include "common/depth/mask/mask_planes.h"

#include <cstring>

namespace copresence::depth {
namespace {

static_assert(static_cast<int>(DepthState::kHole) == 0 && static_cast<int>(DepthState::kMeasured) == 1 &&
              static_cast<int>(DepthState::kFilled) == 2);

// Converts up to 64 states (bytes of 0, 1 or 2) to one bit per state in each plane, and back. A
// multiplication converts eight states at a time.
struct Bits {
  std::uint64_t measured, filled;
};

constexpr std::uint64_t kLowBits = 0x0101010101010101u;

Bits gather_states(const std::uint8_t* states, int count) {
  Bits bits{0, 0};
  for (int i = 0; i < count; i += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, states + i, static_cast<std::size_t>(std::min(8, count - i)));
    bits.measured |= ((eight & kLowBits) * 0x0102040810204080u >> 56) << i;
    bits.filled |= ((eight >> 1 & kLowBits) * 0x0102040810204080u >> 56) << i;
  }
  return bits;
}

// Returns a number whose byte i is bit i of `eight`.
std::uint64_t spread(std::uint64_t eight) {
  const std::uint64_t bit_of_byte = (eight & 255) * kLowBits & 0x8040201008040201u;
  return (bit_of_byte + 0x00406070787c7e7fu) >> 7 & kLowBits;
}

void spread_states(Bits bits, std::uint8_t* states, int count) {
  for (int i = 0; i < count; i += 8) {
    const std::uint64_t eight = spread(bits.measured >> i) | spread(bits.filled >> i) << 1;
    std::memcpy(states + i, &eight, static_cast<std::size_t>(std::min(8, count - i)));
  }
}

// Each bit of the result is set if it and the two bits on either side are all set (any_of_five():
// if any of them is set). Reads `w[-1]` and `w[1]`, too.
std::uint64_t all_of_five(const std::uint64_t* w) {
  return *w & (*w << 1 | w[-1] >> 63) & (*w << 2 | w[-1] >> 62) & (*w >> 1 | w[1] << 63) &
         (*w >> 2 | w[1] << 62);
}

std::uint64_t any_of_five(const std::uint64_t* a, const std::uint64_t* b) {
  const std::uint64_t before = a[-1] | b[-1], w = *a | *b, after = a[1] | b[1];
  return w | w << 1 | before >> 63 | w << 2 | before >> 62 | w >> 1 | after << 63 | w >> 2 | after << 62;
}

}  // namespace

bool pack(const StateImage& states, MaskPlanes& planes) {
  std::uint64_t any_filled = 0;
  for (int y = 0; y < states.height(); ++y) {
    const auto* from = reinterpret_cast<const std::uint8_t*>(states.row(y).data());
    for (int x = 0; x < states.width(); x += 64) {
      const Bits bits = gather_states(from + x, std::min(64, states.width() - x));
      planes.measured.row(y)[x >> 6] = bits.measured;
      planes.filled.row(y)[x >> 6] = bits.filled;
      any_filled |= bits.filled;
    }
  }
  return any_filled != 0;
}

void unpack(const MaskPlanes& planes, StateImage& states) {
  for (int y = 0; y < states.height(); ++y) {
    auto* const to = reinterpret_cast<std::uint8_t*>(states.row(y).data());
    for (int x = 0; x < states.width(); x += 64) {
      spread_states({planes.measured.row(y)[x >> 6], planes.filled.row(y)[x >> 6]}, to + x,
                    std::min(64, states.width() - x));
    }
  }
}

MaskContext::MaskContext(int width)
    : count_(static_cast<std::size_t>((width + 63) / 64 + 2)),
      rows_(4 * count_),
      uniform_(3, RowBits(width)),
      any_uniform_(width) {}

void MaskContext::find(const MaskPlanes& now, const MaskPlanes& earlier, int y) {
  std::uint64_t *const m_all = rows_.data(), *const m_any = m_all + count_, *const f_all = m_any + count_,
                       *const f_any = f_all + count_;
  gather(now.measured, earlier.measured, y, m_all, m_any);
  gather(now.filled, earlier.filled, y, f_all, f_any);
  std::uint64_t *const hole = uniform_[0].words(), *const measured = uniform_[1].words(),
                       *const filled = uniform_[2].words(), *const any = any_uniform_.words();
  for (std::size_t i = 1; i + 1 < count_; ++i) {
    measured[i - 1] = all_of_five(m_all + i);
    filled[i - 1] = all_of_five(f_all + i);
    hole[i - 1] = ~any_of_five(m_any + i, f_any + i);
    any[i - 1] = measured[i - 1] | filled[i - 1] | hole[i - 1];
  }
}

void MaskContext::gather(const BitPlane& now, const BitPlane& earlier, int y, std::uint64_t* all,
                         std::uint64_t* any) const {
  const std::uint64_t* const above = now.row(y - 1) - 1;
  const std::uint64_t* const before_above = earlier.row(y - 1) - 1;
  const std::uint64_t* const before = earlier.row(y) - 1;
  const std::uint64_t* const before_below = earlier.row(y + 1) - 1;
  for (std::size_t i = 0; i < count_; ++i) {
    all[i] = above[i] & before_above[i] & before[i] & before_below[i];
    any[i] = above[i] | before_above[i] | before[i] | before_below[i];
  }
}

}  // namespace copresence::depth
