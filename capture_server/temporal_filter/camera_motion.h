#pragma once

// Detects a moving camera from the blocks of a picture that have changed.
//
// If the camera moves, surfaces move all over the picture. Somebody who walks past a still camera
// changes a part of it only, even if that part is large.
//
// Thread: one thread at a time per object.

#include <array>
#include <cstddef>

namespace copresence::temporal_filter {

class CameraMotion {
 public:
  static constexpr int kAcross = 8, kDown = 6;   ///< regions of the picture
  static constexpr float kMovingBlocks = 0.25F;  ///< share of a region's blocks at which the region moves
  static constexpr float kMovingRegions = 0.7F;  ///< share of regions at which the camera moves
  /// Share of a region's blocks that must have depth. Other regions do not count.
  static constexpr float kWithDepth = 0.25F;
  /// The camera counts as still after this many frames without motion.
  static constexpr int kStillFrames = 8;

  /// For a picture of `columns` x `rows` blocks.
  CameraMotion(int columns, int rows);

  /// Adds a block with depth of the current frame.
  void add(int column, int row, bool moves);

  /// Ends the current frame. Returns whether it shows motion of the camera.
  bool end_frame();

  /// Whether the camera moves, or has moved within the last kStillFrames frames.
  bool is_moving() const { return still_frames_ < kStillFrames; }

 private:
  struct Region {
    int blocks = 0, moving = 0;
  };
  int columns_, rows_;
  std::array<Region, static_cast<std::size_t>(kAcross* kDown)> regions_{};
  int still_frames_ = kStillFrames;
};

}  // namespace copresence::temporal_filter
