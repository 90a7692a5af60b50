#include "common/depth/mask/validity_mask.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "common/depth/entropy/range_coder.h"
#include "common/depth/mask/mask_planes.h"

namespace copresence::depth {
namespace {

// A run with unexpected states is halved until its length is below twice kLeastRun.
constexpr int kLeastRun = 8;
constexpr int kStretch = 48;               // Number of pixels in a stretch; see Windows.
constexpr std::size_t kMostDecisions = 4;  // Per pixel: two for its state, fewer than two for runs.

struct Models {
  std::array<BinaryContext, 1 << 17> measured;
  std::array<BinaryContext, 1 << 12> filled;
  // Indexed by expected state, whether the run is known to be mixed, and its length in bits.
  std::array<std::array<std::array<BinaryContext, 14>, 2>, 3> as_expected;
  BinaryContext any_filled;
};

// A row is coded in stretches of kStretch pixels. The windows hold the states of 64 pixels around a
// stretch, in the rows above it and in the frame before. Pixel i of the stretch has bit i + 2 of
// each window.
struct Windows {
  std::uint64_t above2, above, before, before_below;

  static Windows at(const BitPlane& now, const BitPlane& earlier, int x, int y) {
    return {BitPlane::window(now.row(y - 2), x - 2), BitPlane::window(now.row(y - 1), x - 2),
            BitPlane::window(earlier.row(y), x - 2), BitPlane::window(earlier.row(y + 1), x - 2)};
  }
};

// The scan over all pixels, for encoder and decoder. Coder::decide() writes or reads a bit.
template <class Coder>
class Scan {
 public:
  Scan(Models& models, Coder& coder, const MaskPlanes& earlier, MaskPlanes& now, int width, int height)
      : models_(models), coder_(coder), earlier_(earlier), now_(now), width_(width), height_(height) {}

  void run(bool any_filled) {
    any_filled_ = coder_.decide(models_.any_filled, any_filled);
    for (int y = 0; y < height_; ++y) {
      context_.find(now_, earlier_, y);
      row(y);
    }
  }

 private:
  void row(int y) {
    coder_.expect(kMostDecisions * static_cast<std::size_t>(width_));
    Coder coder = coder_;  // A local copy, which the compiler keeps in registers.
    left_measured_ = left_filled_ = 0;
    std::uint64_t* const measured = now_.measured.row(y);
    std::uint64_t* const filled = now_.filled.row(y);
    // At least one pixel between x and this column is known to differ from the expected state.
    int mixed_until = 0;
    for (int x = 0; x < width_;) {
      const int state = state_to_the_left();
      const bool mixed = x < mixed_until;
      int count = mixed       ? mixed_until - x
                  : state < 0 ? 0
                              : context_.uniform(state).run_of(true, x, width_ - x);
      if (count > 0 && !(mixed && count < 2 * kLeastRun)) {
        if (mixed) count /= 2;
        BinaryContext& model =
            models_.as_expected[state][mixed][std::bit_width(static_cast<unsigned>(count))];
        if (coder.decide(model, !Coder::kReads && all_are(state, measured, filled, x, count))) {
          if constexpr (Coder::kReads) {
            if (state == 1) set(measured, x, count);
            if (state == 2) set(filled, x, count);
          }
          left_measured_ = state == 1 ? ~std::uint64_t{0} : 0;
          left_filled_ = state == 2 ? ~std::uint64_t{0} : 0;
          x += count;
        } else {
          mixed_until = x + count;
        }
        continue;
      }
      if (count == 0)
        count = std::max(context_.uniform().run_of(false, x, std::min(kStretch, width_ - x)),
                         std::min(2, width_ - x));
      if (any_filled_) {
        pixels<true>(coder, x, y, count, measured, filled);
      } else {
        pixels<false>(coder, x, y, count, measured, filled);
      }
      x += count;
    }
    coder_ = coder;
  }

  // Returns the state of the two pixels to the left, or -1 if they differ.
  int state_to_the_left() const {
    const std::uint64_t m = left_measured_ & 3, f = left_filled_ & 3;
    return m == 3 ? 1 : m != 0 ? -1 : f == 3 ? 2 : f != 0 ? -1 : 0;
  }

  // Returns a word with the bits `first` to `end` - 1 set. Requires 0 <= first < end <= 64.
  static std::uint64_t bits(int first, int end) {
    return (~std::uint64_t{0} >> (64 - (end - first))) << first;
  }

  static bool all_are(int state, const std::uint64_t* measured, const std::uint64_t* filled, int x,
                      int count) {
    for (const int end = x + count; x < end;) {
      const int word = x >> 6, stop = std::min(end, (word + 1) << 6);
      const std::uint64_t mask = bits(x & 63, stop - (word << 6));
      if ((measured[word] & mask) != (state == 1 ? mask : 0)) return false;
      if ((filled[word] & mask) != (state == 2 ? mask : 0)) return false;
      x = stop;
    }
    return true;
  }

  static void set(std::uint64_t* row, int x, int count) {
    for (const int end = x + count; x < end;) {
      const int word = x >> 6, stop = std::min(end, (word + 1) << 6);
      row[word] |= bits(x & 63, stop - (word << 6));
      x = stop;
    }
  }

  // Codes each pixel separately.
  template <bool kFilled>
  void pixels(Coder& coder, int x, int y, int count, std::uint64_t* measured, std::uint64_t* filled) {
    Windows m = Windows::at(now_.measured, earlier_.measured, x, y);
    Windows f{};
    if (kFilled) f = Windows::at(now_.filled, earlier_.filled, x, y);
    std::uint64_t known_measured = 0, known_filled = 0;
    if constexpr (!Coder::kReads) {
      known_measured = BitPlane::window(measured, x);
      known_filled = BitPlane::window(filled, x);
    }
    std::uint64_t got_measured = 0, got_filled = 0;
    std::uint64_t left_measured = left_measured_, left_filled = left_filled_;
    const auto known_context = [&] {  // The context without the pixels to the left.
      return (m.above & 31) << 3 | (m.above2 >> 1 & 7) << 8 | (m.before >> 1 & 7) << 11 |
             (m.before_below >> 1 & 7) << 14;
    };
    std::uint64_t next_context = known_context();
    for (int i = 0; i < count; ++i) {
      const std::uint64_t context = (left_measured & 7) | next_context;
      const std::uint64_t m_above = m.above, m_before = m.before;
      m.above >>= 1, m.above2 >>= 1, m.before >>= 1, m.before_below >>= 1;
      next_context = known_context();
      // The pixels to the left select one of eight models, which are in one cache line.
      __builtin_prefetch(&models_.measured[next_context]);
      const bool is_measured = coder.decide(models_.measured[context], known_measured >> i & 1);
      bool is_filled = false;
      if (kFilled && !is_measured) {
        const std::uint64_t filled_context =
            (left_filled & 3) | (left_measured & 1) << 2 | (f.above >> 1 & 7) << 3 | (m_above >> 2 & 1) << 6 |
            (f.before >> 1 & 7) << 7 | (m_before >> 2 & 1) << 10 | (f.before_below >> 2 & 1) << 11;
        is_filled = coder.decide(models_.filled[filled_context], known_filled >> i & 1);
      }
      got_measured |= std::uint64_t{is_measured} << i;
      if constexpr (kFilled) got_filled |= std::uint64_t{is_filled} << i;
      left_measured = left_measured << 1 | std::uint64_t{is_measured};
      if constexpr (kFilled) left_filled = left_filled << 1 | std::uint64_t{is_filled};
      if constexpr (kFilled) f.above >>= 1, f.before >>= 1, f.before_below >>= 1;
    }
    left_measured_ = left_measured;
    left_filled_ = kFilled ? left_filled : 0;
    if constexpr (Coder::kReads) {
      put(measured, x, got_measured);
      put(filled, x, got_filled);
    }
  }

  static void put(std::uint64_t* row, int x, std::uint64_t got) {
    row[x >> 6] |= got << (x & 63);
    row[(x >> 6) + 1] |= got >> 1 >> (63 - (x & 63));
  }

  Models& models_;
  Coder& coder_;
  const MaskPlanes& earlier_;
  MaskPlanes& now_;
  const int width_, height_;
  MaskContext context_{width_};
  std::uint64_t left_measured_ = 0,
                left_filled_ = 0;  // States of the pixels to the left; the nearest is in bit 0.
  bool any_filled_ = false;
};

struct Writer {
  static constexpr bool kReads = false;
  std::vector<std::uint8_t>* buffer;
  RangeEncoder range{buffer->data()};
  bool decide(BinaryContext& model, bool bit) {
    range.encode(model, bit);
    return bit;
  }
  void expect(std::size_t decisions) {
    const auto used = static_cast<std::size_t>(range.next() - buffer->data());
    const std::size_t needed = used + decisions * RangeEncoder::kMostBytes + RangeEncoder::kEndBytes;
    if (needed <= buffer->size()) return;
    buffer->resize(2 * needed);
    range.move_to(buffer->data() + used);
  }
};

struct Reader {
  static constexpr bool kReads = true;
  RangeDecoder range;
  bool decide(BinaryContext& model, bool) { return range.decode(model); }
  void expect(std::size_t) {}
};

}  // namespace

struct ValidityMaskMemory {
  ValidityMaskMemory(int w, int h) : width(w), height(h), now{{w, h}, {w, h}}, earlier(now) {}

  // Begins a new frame. A complete mask does not depend on earlier frames.
  void next(bool complete) {
    std::swap(now, earlier);
    if (!complete) return;
    earlier.clear();
    models.measured.fill({});
    models.filled.fill({});
    models.as_expected = {};
    models.any_filled = {};
  }

  int width, height;
  MaskPlanes now, earlier;
  Models models;
  std::vector<std::uint8_t> buffer;  // Used by the encoder.
};

ValidityMaskEncoder::ValidityMaskEncoder(int width, int height)
    : memory_(std::make_unique<ValidityMaskMemory>(width, height)) {}
ValidityMaskEncoder::~ValidityMaskEncoder() = default;
ValidityMaskEncoder::ValidityMaskEncoder(ValidityMaskEncoder&&) noexcept = default;
ValidityMaskEncoder& ValidityMaskEncoder::operator=(ValidityMaskEncoder&&) noexcept = default;

void ValidityMaskEncoder::encode(const StateImage& states, bool complete, std::vector<std::uint8_t>& out) {
  ValidityMaskMemory& memory = *memory_;
  assert(states.width() == memory.width && states.height() == memory.height);
  memory.next(complete);
  const bool any_filled = pack(states, memory.now);
  Writer writer{&memory.buffer};
  writer.expect(1);
  Scan(memory.models, writer, memory.earlier, memory.now, memory.width, memory.height).run(any_filled);
  const std::uint8_t* end = writer.range.finish();
  const std::uint8_t* const begin = memory.buffer.data();
  while (end != begin && end[-1] == 0) --end;
  out.insert(out.end(), begin, end);
}

ValidityMaskDecoder::ValidityMaskDecoder(int width, int height)
    : memory_(std::make_unique<ValidityMaskMemory>(width, height)) {}
ValidityMaskDecoder::~ValidityMaskDecoder() = default;
ValidityMaskDecoder::ValidityMaskDecoder(ValidityMaskDecoder&&) noexcept = default;
ValidityMaskDecoder& ValidityMaskDecoder::operator=(ValidityMaskDecoder&&) noexcept = default;

void ValidityMaskDecoder::decode(std::span<const std::uint8_t> bytes, bool complete, StateImage& states) {
  ValidityMaskMemory& memory = *memory_;
  memory.next(complete);
  memory.now.clear();
  Reader reader{RangeDecoder(bytes)};
  Scan(memory.models, reader, memory.earlier, memory.now, memory.width, memory.height).run(false);
  states.resize(memory.width, memory.height);
  unpack(memory.now, states);
}

}  // namespace copresence::depth
