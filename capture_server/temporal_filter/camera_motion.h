#pragma once

// Detects a moving camera from the blocks of a picture that have changed.
//
// If the camera moves, blocks change all over the picture. A person who walks past a still camera
// changes only a part of the picture, even if that part is large.
//
// Thread: one thread at a time per object.

#include <array>
#include <cstddef>

namespace copresence::temporal_filter {

class CameraMotion {
 public:
  static constexpr int kAcross = 8, kDown = 6;  ///< Number of regions across and down.
  /// A region moves if at least this share of its blocks with depth moves.
  static constexpr float kMovingBlocks = 0.25F;
  /// The camera moves if at least this share of the regions moves.
  static constexpr float kMovingRegions = 0.7F;
  /// Minimum share of blocks with depth in a region. Other regions are ignored.
  static constexpr float kWithDepth = 0.25F;
  /// The camera counts as still after this many frames without motion.
  static constexpr int kStillFrames = 8;

  /// Creates a detector for pictures of `columns` x `rows` blocks.
  CameraMotion(int columns, int rows);

  /// Adds a block of the current frame. Call this for blocks with depth only.
  void add(int column, int row, bool moves);

  /// Ends the current frame. Returns true if the frame shows that the camera moves.
  bool end_frame();

  /// Returns true if the camera has moved within the last kStillFrames frames.
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
