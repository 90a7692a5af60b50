#include "common/depth/entropy/range_coder.h"

namespace copresence::depth {

std::uint8_t* RangeEncoder::finish() {
  // Any number of the interval does; the one with the most zero bytes at its end is the shortest, since a
  // reader past the end sees zeros. The range is at least kBottom, so one byte below the carry is enough.
  low_ = (low_ + kBottom - 1) & ~std::uint64_t{kBottom - 1};
  shift_low();
  return next_;
}

}  // namespace copresence::depth
