#include "common/video/video_settings.h"

#include <fmt/format.h>

namespace copresence::video {
namespace {

Result<void> check_rate(const char* what, int kbps) {
  if (kbps >= kMinKbps && kbps <= kMaxKbps) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{} of {} kbit/s cannot be used: give {} to {}", what, kbps, kMinKbps, kMaxKbps));
}

}  // namespace

Result<void> check(const VideoSettings& settings) {
  if (settings.depth_qp < 0 || settings.depth_qp > kMaxDepthQp) {
    return fail(ErrorCode::kInvalid, fmt::format("a depth QP of {} cannot be used: give 0 (lossless) to {}",
                                                 settings.depth_qp, kMaxDepthQp));
  }
  if (settings.depth_kbps) {
    if (auto checked = check_rate("a depth rate", *settings.depth_kbps); !checked) return checked;
  }
  return check_rate("a colour rate", settings.color_kbps);
}

}  // namespace copresence::video
