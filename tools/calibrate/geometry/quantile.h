#pragma once

// Quantiles of a few numbers. Thread: pure functions.

#include <algorithm>
#include <vector>

namespace copresence::calibrate {

/// The value below which `share` (0 to 1) of the values lie, without interpolation; 0 if none.
template <class Value>
Value quantile(std::vector<Value> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

template <class Value>
Value median(std::vector<Value> values) {
  return quantile(std::move(values), 0.5);
}

}  // namespace copresence::calibrate
