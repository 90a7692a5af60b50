// Reads and writes the change of a codebook (docs/internals/codecs.md, Codebook). Numbers are
// range-coded with contexts that are reset for each change. Each level is predicted from earlier
// levels, and its difference from the prediction is coded. A sensor's levels are even in 1/z, so
// most levels take half a byte.

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <string>

#include "common/depth/entropy/range_coder.h"
#include "common/depth/levels/codebook.h"

namespace copresence::depth {
namespace {

constexpr int kNumberBits = 17;  // Numbers are below 2^17 - 1.
// The next entry is predicted from two earlier entries that are this many entries apart.
constexpr std::size_t kBase = 8;

// Codes a number: the bit length of number + 1 in unary, then its bits below the leading one.
class NumberModel {
 public:
  template <class Code>
  std::uint32_t pass(const Code& code, std::uint32_t value) {
    const int bits = std::bit_width(value + 1);
    int length = 1;
    while (length < kNumberBits && code(longer_[length - 1], bits > length)) ++length;
    std::uint32_t read = 1;
    for (int bit = length - 2; bit >= 0; --bit) {
      // The first bits below the leading one have their own contexts. All lower bits share one
      // context.
      BinaryContext& model = read < kLearnt ? lower_[length][read] : even_;
      read = read << 1 | code(model, (value + 1) >> bit & 1);
    }
    return read - 1;
  }

 private:
  static constexpr std::uint32_t kLearnt = 4;

  std::array<BinaryContext, kNumberBits> longer_;
  std::array<std::array<BinaryContext, kLearnt>, kNumberBits + 1> lower_;
  BinaryContext even_;
};

struct Entry {
  std::int64_t code, level;
};

// The sequence of decisions, shared by writer and reader. `code` writes a decision, or reads one
// and ignores its argument.
class ChangeModel {
 public:
  explicit ChangeModel(int nearest) : nearest_(nearest) {}

  template <class Code>
  std::uint32_t count(const Code& code, std::uint32_t entries) {
    return count_.pass(code, entries);
  }

  // Codes the next entry. The entry's level is 0 if the code has no level.
  template <class Code>
  Entry entry(const Code& code, const Entry& next) {
    const std::int64_t last = codes_so_far_;
    Entry entry{last + 1 + skip_.pass(code, static_cast<std::uint32_t>(next.code - last - 1)), 0};
    codes_so_far_ = entry.code;
    if (code(none_, next.level == 0)) return entry;
    const Prediction predicted = predict(entry.code);
    const std::int64_t off = next.level - predicted.level;
    auto& model = off_[std::min<std::size_t>(std::bit_width(static_cast<std::uint64_t>(predicted.reach)),
                                             off_.size() - 1)];
    const std::uint32_t zigzag = static_cast<std::uint32_t>(off < 0 ? -2 * off - 1 : 2 * off);
    const std::uint32_t read = model.pass(code, zigzag);
    entry.level = predicted.level + (read & 1 ? -static_cast<std::int64_t>(read / 2) - 1 : read / 2);
    known_[count_known_++ % kBase] = entry;
    return entry;
  }

 private:
  struct Prediction {
    std::int64_t level, reach;  // `reach` is the distance of the prediction from the last entry's level.
  };

  // Predicts from the last entry and the kBase-th entry before it (or the first), evenly in 1/z.
  Prediction predict(std::int64_t code) const {
    if (count_known_ == 0) return {nearest_, 0};
    const Entry& last = known_[(count_known_ - 1) % kBase];
    const Entry& base = known_[count_known_ < kBase ? 0 : count_known_ % kBase];
    if (count_known_ == 1) return {last.level, 0};
    // Extrapolate 1/level linearly from `last` and `base`. Integers give the same result on every
    // machine.
    const std::int64_t over = last.level * base.level * (last.code - base.code);
    const std::int64_t under =
        base.level * (last.code - base.code) + (base.level - last.level) * (code - last.code);
    if (under <= 0) return {last.level, 0};
    const std::int64_t level = std::clamp<std::int64_t>((over + under / 2) / under, 1, 65535);
    return {level, std::max<std::int64_t>(level - last.level, 0)};
  }

  std::int64_t nearest_;
  std::int64_t codes_so_far_ = -1;
  std::array<Entry, kBase> known_{};  // The last entries with a level, as a ring buffer.
  std::size_t count_known_ = 0;
  NumberModel count_, skip_;
  std::array<NumberModel, 5> off_;  // Indexed by the bit length of the predicted difference.
  BinaryContext none_;
};

// Largest number of decisions of an entry: two numbers, and whether it has a level.
constexpr std::size_t kMostDecisions = 2 * (2 * kNumberBits) + 1;

}  // namespace

void Codebook::write_change(const Codebook& earlier, std::vector<std::uint8_t>& out) const {
  std::uint32_t entries = 0;
  for (int code = 0; code < kCodes; ++code) entries += levels_[code] != earlier.levels_[code];
  if (entries == 0) return;
  std::vector<std::uint8_t> buffer((entries + 1) * kMostDecisions * RangeEncoder::kMostBytes +
                                   RangeEncoder::kEndBytes);
  RangeEncoder encoder(buffer.data());
  const auto write = [&](BinaryContext& model, bool bit) {
    encoder.encode(model, bit);
    return bit;
  };
  ChangeModel model(range_.near);
  model.count(write, entries - 1);
  for (int code = 0; code < kCodes; ++code) {
    if (levels_[code] != earlier.levels_[code]) model.entry(write, {code, levels_[code]});
  }
  const std::uint8_t* end = encoder.finish();
  while (end - buffer.data() > 1 && end[-1] == 0) --end;  // Keep one byte, since no bytes mean no change.
  out.insert(out.end(), static_cast<const std::uint8_t*>(buffer.data()), end);
}

Result<void> Codebook::read_change(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const auto corrupt = [](const char* why) {
    return fail(ErrorCode::kCorrupt, std::string("codebook: ") + why);
  };
  RangeDecoder decoder(bytes);
  const auto read = [&](BinaryContext& model, bool) { return decoder.decode(model); };
  ChangeModel model(range_.near);
  const std::uint32_t entries = model.count(read, 0) + 1;
  if (entries > kCodes) return corrupt("the number of entries is impossible");
  std::vector<std::uint16_t> levels = levels_;
  for (std::uint32_t i = 0; i < entries; ++i) {
    const Entry entry = model.entry(read, {0, 1});
    if (entry.code >= kCodes) return corrupt("a code is too large");
    if (entry.level != 0 && (entry.level < range_.near || entry.level > range_.far))
      return corrupt("a level lies outside the range");
    levels[static_cast<std::size_t>(entry.code)] = static_cast<std::uint16_t>(entry.level);
  }
  std::uint16_t last = 0;
  for (const std::uint16_t each : levels) {
    if (each == 0) continue;
    if (each <= last) return corrupt("levels do not ascend");
    last = each;
  }
  levels_ = std::move(levels);
  return {};
}

}  // namespace copresence::depth
