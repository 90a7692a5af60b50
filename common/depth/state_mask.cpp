#include "common/depth/state_mask.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "common/depth/bit_plane.h"
#include "common/depth/range_coder.h"

namespace copresence::depth {
namespace {

constexpr int kGroup = 8;  // pixels

// States as two bit planes; a hole is in neither.
struct Planes {
  BitPlane measured, filled;
  void clear() { measured.clear(), filled.clear(); }
};

struct Models {
  std::array<AdaptiveBit, 1 << 17> measured;
  std::array<AdaptiveBit, 1 << 12> filled;
  std::array<AdaptiveBit, 3> as_expected;  // by the expected state
};

// The neighbourhood of one group in one plane: pixel x of the group is bit x + 2 of every window.
struct Windows {
  std::uint64_t above2, above, before, before_below;

  static Windows at(const BitPlane& now, const BitPlane& earlier, int x, int y) {
    return {BitPlane::window(now.row(y - 2), x - 2), BitPlane::window(now.row(y - 1), x - 2),
            BitPlane::window(earlier.row(y), x - 2), BitPlane::window(earlier.row(y + 1), x - 2)};
  }
};

// What the rows around a row have in common, for one plane: bits set in all of them and in any of them.
class RowsAround {
 public:
  explicit RowsAround(int width) : all_(row_words(width)), any_(all_.size()) {}

  void look(const BitPlane& now, const BitPlane& earlier, int y) {
    const std::uint64_t* const above = now.row(y - 1) - 1;
    const std::uint64_t* const before_above = earlier.row(y - 1) - 1;
    const std::uint64_t* const before = earlier.row(y) - 1;
    const std::uint64_t* const before_below = earlier.row(y + 1) - 1;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      all_[i] = above[i] & before_above[i] & before[i] & before_below[i];
      any_[i] = above[i] | before_above[i] | before[i] | before_below[i];
    }
  }

  // Whether all pixels around the group at x are set, or none is: in these rows, two to either side, and the two to the left.
  bool all_set(int x, std::uint64_t left) const {
    return (BitPlane::window(all_.data() + 1, x - 2) & kWide) == kWide && (left & 3) == 3;
  }
  bool all_clear(int x, std::uint64_t left) const {
    return (BitPlane::window(any_.data() + 1, x - 2) & kWide) == 0 && (left & 3) == 0;
  }

 private:
  static constexpr std::uint64_t kWide = (std::uint64_t{1} << (kGroup + 4)) - 1;
  static std::size_t row_words(int width) { return static_cast<std::size_t>((width + 63) / 64 + 2); }
  std::vector<std::uint64_t> all_, any_;  // with the planes' margin of a word on either side
};

// One walk for both directions. Coder::decide(model, bit) writes the bit, or reads and returns it.
template <class Coder>
class Walk {
 public:
  Walk(Models& models, Coder& coder, const Planes& earlier, Planes& now, int width, int height)
      : models_(models), coder_(coder), earlier_(earlier), now_(now), width_(width), height_(height) {}

  void run() {
    for (int y = 0; y < height_; ++y) {
      measured_around_.look(now_.measured, earlier_.measured, y);
      filled_around_.look(now_.filled, earlier_.filled, y);
      std::uint64_t left_measured = 0, left_filled = 0;  // the pixels to the left, nearest in bit 0
      for (int x = 0; x < width_; x += kGroup) group(x, y, left_measured, left_filled);
    }
  }

 private:
  void group(int x, int y, std::uint64_t& left_measured, std::uint64_t& left_filled) {
    const int count = std::min(kGroup, width_ - x);
    const std::uint64_t all = (std::uint64_t{1} << count) - 1;
    std::uint64_t* const row_measured = now_.measured.row(y) + (x >> 6);
    std::uint64_t* const row_filled = now_.filled.row(y) + (x >> 6);
    const int shift = x & 63;
    std::uint64_t group_measured = *row_measured >> shift & all, group_filled = *row_filled >> shift & all;

    std::uint64_t expected_measured = 0, expected_filled = 0;
    bool uniform = true;
    if (measured_around_.all_set(x, left_measured)) {
      expected_measured = all;
    } else if (!measured_around_.all_clear(x, left_measured)) {
      uniform = false;
    } else if (filled_around_.all_set(x, left_filled)) {
      expected_filled = all;
    } else if (!filled_around_.all_clear(x, left_filled)) {
      uniform = false;
    }
    const int expected = expected_measured ? 1 : expected_filled ? 2 : 0;
    if (uniform && coder_.decide(models_.as_expected[expected],
                                 group_measured == expected_measured && group_filled == expected_filled)) {
      group_measured = expected_measured;
      group_filled = expected_filled;
      left_measured = expected_measured ? ~std::uint64_t{0} : 0;
      left_filled = expected_filled ? ~std::uint64_t{0} : 0;
    } else {
      pixels(count, Windows::at(now_.measured, earlier_.measured, x, y),
             Windows::at(now_.filled, earlier_.filled, x, y), left_measured, left_filled, group_measured,
             group_filled);
    }
    if constexpr (Coder::kReads) {
      *row_measured |= group_measured << shift;
      *row_filled |= group_filled << shift;
    }
  }

  void pixels(int count, Windows m, Windows f, std::uint64_t& left_measured, std::uint64_t& left_filled,
              std::uint64_t& group_measured, std::uint64_t& group_filled) {
    std::uint64_t got_measured = 0, got_filled = 0;
    for (int i = 0; i < count; ++i) {
      const std::uint64_t context = (left_measured & 7) | (m.above & 31) << 3 | (m.above2 >> 1 & 7) << 8 |
                                    (m.before >> 1 & 7) << 11 | (m.before_below >> 1 & 7) << 14;
      const bool is_measured = coder_.decide(models_.measured[context], group_measured >> i & 1);
      bool is_filled = false;
      if (!is_measured) {
        const std::uint64_t filled_context =
            (left_filled & 3) | (left_measured & 1) << 2 | (f.above >> 1 & 7) << 3 | (m.above >> 2 & 1) << 6 |
            (f.before >> 1 & 7) << 7 | (m.before >> 2 & 1) << 10 | (f.before_below >> 2 & 1) << 11;
        is_filled = coder_.decide(models_.filled[filled_context], group_filled >> i & 1);
      }
      got_measured |= std::uint64_t{is_measured} << i;
      got_filled |= std::uint64_t{is_filled} << i;
      left_measured = left_measured << 1 | std::uint64_t{is_measured};
      left_filled = left_filled << 1 | std::uint64_t{is_filled};
      m.above >>= 1, m.above2 >>= 1, m.before >>= 1, m.before_below >>= 1;
      f.above >>= 1, f.before >>= 1, f.before_below >>= 1;
    }
    group_measured = got_measured;
    group_filled = got_filled;
  }

  Models& models_;
  Coder& coder_;
  const Planes& earlier_;
  Planes& now_;
  const int width_, height_;
  RowsAround measured_around_{width_}, filled_around_{width_};
};

struct Writer {
  static constexpr bool kReads = false;
  RangeEncoder range;
  bool decide(AdaptiveBit& model, bool bit) {
    range.encode(model, bit);
    return bit;
  }
};

struct Reader {
  static constexpr bool kReads = true;
  RangeDecoder range;
  bool decide(AdaptiveBit& model, bool) { return range.decode(model); }
};

// Eight states (bytes of 0, 1 or 2) to eight bits of each plane: a multiplication gathers the lowest bits of
// eight bytes.
constexpr std::uint64_t kLowBits = 0x0101010101010101u;
std::uint64_t gather_low_bits(std::uint64_t bytes) {
  return (bytes & kLowBits) * 0x0102040810204080u >> 56;
}

void pack(const StateImage& states, Planes& planes) {
  const int width = states.width();
  for (int y = 0; y < states.height(); ++y) {
    const auto* from = reinterpret_cast<const std::uint8_t*>(states.row(y).data());
    std::uint64_t* measured = planes.measured.row(y);
    std::uint64_t* filled = planes.filled.row(y);
    for (int x = 0; x < width; x += 64) {
      std::uint64_t m = 0, f = 0;
      for (int i = 0; i < 64 && x + i < width; i += 8) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, from + x + i, static_cast<std::size_t>(std::min(8, width - x - i)));
        m |= gather_low_bits(eight) << i;
        f |= gather_low_bits(eight >> 1) << i;
      }
      measured[x >> 6] = m;
      filled[x >> 6] = f;
    }
  }
}

// Eight bits to eight bytes of 0 or 1, by table.
constexpr std::array<std::uint64_t, 256> kSpread = [] {
  std::array<std::uint64_t, 256> spread{};
  for (int bits = 0; bits < 256; ++bits) {
    for (int i = 0; i < 8; ++i) spread[bits] |= static_cast<std::uint64_t>(bits >> i & 1) << 8 * i;
  }
  return spread;
}();

void unpack(const Planes& planes, StateImage& states) {
  const int width = states.width();
  for (int y = 0; y < states.height(); ++y) {
    auto* to = reinterpret_cast<std::uint8_t*>(states.row(y).data());
    const std::uint64_t* measured = planes.measured.row(y);
    const std::uint64_t* filled = planes.filled.row(y);
    for (int x = 0; x < width; x += 8) {
      const int shift = x & 63;
      const std::uint64_t eight =
          kSpread[measured[x >> 6] >> shift & 255] | kSpread[filled[x >> 6] >> shift & 255] << 1;
      std::memcpy(to + x, &eight, static_cast<std::size_t>(std::min(8, width - x)));
    }
  }
}

static_assert(static_cast<int>(DepthState::kHole) == 0 && static_cast<int>(DepthState::kMeasured) == 1 &&
              static_cast<int>(DepthState::kFilled) == 2);

}  // namespace

struct StateMaskMemory {
  StateMaskMemory(int w, int h) : width(w), height(h), now{{w, h}, {w, h}}, earlier(now) {}

  // Makes room for a new frame; a complete mask starts from nothing.
  void next(bool complete) {
    std::swap(now, earlier);
    if (!complete) return;
    earlier.clear();
    models.measured.fill({});
    models.filled.fill({});
    models.as_expected.fill({});
  }

  int width, height;
  Planes now, earlier;
  Models models;
};

StateMaskEncoder::StateMaskEncoder(int width, int height)
    : memory_(std::make_unique<StateMaskMemory>(width, height)) {}
StateMaskEncoder::~StateMaskEncoder() = default;
StateMaskEncoder::StateMaskEncoder(StateMaskEncoder&&) noexcept = default;
StateMaskEncoder& StateMaskEncoder::operator=(StateMaskEncoder&&) noexcept = default;

void StateMaskEncoder::encode(const StateImage& states, bool complete, std::vector<std::uint8_t>& out) {
  StateMaskMemory& memory = *memory_;
  assert(states.width() == memory.width && states.height() == memory.height);
  memory.next(complete);
  pack(states, memory.now);
  Writer writer;
  Walk(memory.models, writer, memory.earlier, memory.now, memory.width, memory.height).run();
  writer.range.finish(out);
}

StateMaskDecoder::StateMaskDecoder(int width, int height)
    : memory_(std::make_unique<StateMaskMemory>(width, height)) {}
StateMaskDecoder::~StateMaskDecoder() = default;
StateMaskDecoder::StateMaskDecoder(StateMaskDecoder&&) noexcept = default;
StateMaskDecoder& StateMaskDecoder::operator=(StateMaskDecoder&&) noexcept = default;

void StateMaskDecoder::decode(std::span<const std::uint8_t> bytes, bool complete, StateImage& states) {
  StateMaskMemory& memory = *memory_;
  memory.next(complete);
  memory.now.clear();
  Reader reader{RangeDecoder(bytes)};
  Walk(memory.models, reader, memory.earlier, memory.now, memory.width, memory.height).run();
  states.resize(memory.width, memory.height);
  unpack(memory.now, states);
}

}  // namespace copresence::depth
