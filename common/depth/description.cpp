#include "common/depth/description.h"

#include <cmath>
#include <sstream>

namespace copresence::depth {

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
