#include "capture_server/temporal_filter/camera_motion.h"

#include <algorithm>

namespace copresence::temporal_filter {

CameraMotion::CameraMotion(int columns, int rows) : columns_(columns), rows_(rows) {}

void CameraMotion::add(int column, int row, bool moves) {
  const int across = column * kAcross / columns_, down = row * kDown / rows_;
  Region& region = regions_[static_cast<std::size_t>(down * kAcross + across)];
  ++region.blocks;
  region.moving += moves;
}

bool CameraMotion::end_frame() {
  const float least = kWithDepth * static_cast<float>(columns_ * rows_) / (kAcross * kDown);
  int counted = 0, moving = 0;
  for (const Region& region : regions_) {
    if (region.blocks == 0 || static_cast<float>(region.blocks) < least) continue;
    ++counted;
    moving += static_cast<float>(region.moving) >= kMovingBlocks * static_cast<float>(region.blocks);
  }
  regions_.fill({});
  const bool moves =
      counted > 0 && static_cast<float>(moving) >= kMovingRegions * static_cast<float>(counted);
  still_frames_ = moves ? 0 : std::min(still_frames_ + 1, kStillFrames);
  return moves;
}

}  // namespace copresence::temporal_filter
