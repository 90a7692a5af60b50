#include "common/depth/depth_format.h"

#include <cmath>
#include <sstream>

#include "common/frame/bounds.h"

namespace copresence::depth {

Result<void> check(const DepthFormat& format) {
  const auto fits = [](int size) { return size >= 2 && size <= 4096 && size % 2 == 0; };
  std::ostringstream why;
  const auto [near_m, far_m] = format.range;
  if (!fits(format.width) || !fits(format.height)) {
    why << "depth of " << format.width << "x" << format.height
        << " pixels cannot be coded: width and height must be even, from 2 to 4096";
  } else if (format.unit != DepthUnit::kMillimetre && format.unit != DepthUnit::k100Micrometres) {
    why << "a depth unit of " << static_cast<int>(format.unit)
        << " micrometres is not known, only 100 and 1000 are";
  } else if (!std::isfinite(near_m) || !std::isfinite(far_m) || near_m <= 0 || near_m >= far_m) {
    why << "the depth range " << near_m << ":" << far_m << " m is empty: near must be above 0 and below far";
  } else if (format.units().near >= format.units().far) {
    why << "the depth range " << near_m << ":" << far_m << " m holds no two values of the stream's 16 bits";
  } else {
    return check_noise(format.noise);
  }
  return fail(ErrorCode::kInvalid, why.str());
}

}  // namespace copresence::depth
