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

Result<double> described(const DepthCodecDescription& description, std::string_view name, double least,
                         double most) {
  for (const auto& [key, value] : description.parameters) {
    if (key != name) continue;
    if (value >= least && value <= most) return value;
    std::ostringstream why;
    why << "depth codec " << description.name << ": the stream's " << name << " is " << value
        << ", not between " << least << " and " << most;
    return fail(ErrorCode::kInvalid, why.str());
  }
  return fail(ErrorCode::kInvalid,
              "depth codec " + description.name + ": the stream does not say " + std::string(name));
}

Result<DepthRangeUnits> described_range(const DepthCodecDescription& description) {
  const auto near = described(description, "near", 1, 65534);
  if (!near) return fail(near.error());
  const auto far = described(description, "far", std::floor(*near) + 1, 65535);
  if (!far) return fail(far.error());
  return DepthRangeUnits{static_cast<std::uint16_t>(*near), static_cast<std::uint16_t>(*far)};
}

}  // namespace copresence::depth
