#include "capture_server/hole_filling/hole_filler.h"

#include <cmath>
#include <string>

#include "capture_server/hole_filling/bilateral_filling.h"
#include "capture_server/hole_filling/gl_joint_filling.h"
#include "capture_server/hole_filling/joint_filling.h"
#include "capture_server/hole_filling/median_filling.h"
#include "common/gl/context.h"

namespace copresence::hole_filling {
namespace {

class NoFilling final : public HoleFiller {
 public:
  std::string_view name() const override { return "cpu"; }
  Result<void> fill(RgbdFrame&) override { return {}; }
};

Result<void> check(const FrameFormat& format) {
  const auto fits = [](int size) { return size >= 2 && size <= 4096 && size % 2 == 0; };
  if (!fits(format.width) || !fits(format.height)) {
    return fail(ErrorCode::kInvalid,
                "depth of " + std::to_string(format.width) + "x" + std::to_string(format.height) +
                    " pixels cannot be filled: width and height must be even, from 2 to 4096");
  }
  const auto [near, far] = format.range;
  if (!std::isfinite(near) || !std::isfinite(far) || near <= 0 || near >= far) {
    return fail(ErrorCode::kInvalid,
                "the depth range must be two positive distances in metres, the nearer one first");
  }
  return {};
}

}  // namespace

std::string_view name(Method method) {
  switch (method) {
    case Method::kOff:
      return "off";
    case Method::kMedian:
      return "median";
    case Method::kBilateral:
      return "bilateral";
    case Method::kJoint:
      return "joint";
  }
  return "";
}

Result<std::unique_ptr<HoleFiller>> open(Method method, Compute compute, const FrameFormat& format) {
  if (auto valid = check(format); !valid) return fail(valid.error());
  if (compute == Compute::kGl && method != Method::kJoint) {
    return fail(ErrorCode::kUnsupported, "hole filling \"" + std::string(name(method)) +
                                             "\" has no shaders: use --compute cpu, or --hole-filling joint");
  }
  if (compute == Compute::kGl) return open_gl_joint_filling(format, false);
  if (compute == Compute::kAuto && method == Method::kJoint && gl::has_graphics_card()) {
    if (auto filler = open_gl_joint_filling(format, true)) return filler;
  }
  switch (method) {
    case Method::kMedian:
      return std::make_unique<MedianFilling>(format);
    case Method::kBilateral:
      return std::make_unique<BilateralFilling>(format);
    case Method::kJoint:
      return std::make_unique<JointFilling>(format);
    case Method::kOff:
      break;
  }
  return std::make_unique<NoFilling>();
}

}  // namespace copresence::hole_filling
