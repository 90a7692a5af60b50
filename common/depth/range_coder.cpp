#include "common/depth/range_coder.h"

namespace copresence::depth {

void RangeEncoder::finish(std::vector<std::uint8_t>& out) {
  // Any number of the interval does; the one with the most zero bytes at its end is the shortest, since a
  // reader past the end sees zeros. The range is at least kBottom, so one byte below the carry is enough.
  low_ = (low_ + kBottom - 1) & ~std::uint64_t{kBottom - 1};
  shift_low();
  shift_low();
  while (!bytes_.empty() && bytes_.back() == 0) bytes_.pop_back();
  out.insert(out.end(), bytes_.begin(), bytes_.end());
  bytes_.clear();
  low_ = 0;
  range_ = 0xffffffffu;
  pending_ = 0;
  started_ = false;
}

}  // namespace copresence::depth
