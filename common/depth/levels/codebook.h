#pragma once

// Codes for a sensor's depth levels. A depth sensor knows only some hundred distances; a level table gives
// each of them a code, in the order of depth, so that a code that lossy coding moved a little stands for a
// depth that moved a little.
//
// Between the levels known so far it leaves as many codes free as a Kinect v1 has steps there (z² / 351.3 m a
// step), so that a level met later mostly finds its place without moving another. A code without a level
// stands for a depth between its neighbours', evenly in 1/z.
//
// The bytes of a change are those of docs/internals/codecs.md (level_table_change.cpp).
//
// Thread: a value.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::depth {

class Codebook {
 public:
  static constexpr int kCodes = 1024;  ///< of a 10-bit picture

  /// No levels yet. Requires 1 <= range.near < range.far.
  Codebook(DepthRangeUnits range, DepthUnit unit);

  /// The level of every code, ascending; 0 for none.
  std::span<const std::uint16_t> levels() const { return levels_; }
  int count() const;

  /// These levels and no others. distance[i] is how many codes level i wants from the level before, the first
  /// one from the first code; what does not fit is scaled down, and every level has a code of its own.
  /// Requires levels ascending, within the range, at most kCodes, and as many distances.
  void assign(std::span<const std::uint16_t> levels, std::span<const double> distance);

  /// Levels even in 1/z over a range within the table's, as many as there are codes, fewer where the unit is
  /// coarser than that: for depth that has more levels than codes.
  void assign_evenly(DepthRangeUnits range);

  /// Gives `level` a code where it belongs between its neighbours; others move only as far as they must.
  /// False where all codes are taken. Requires a level within the range that is not in the table.
  bool insert(std::uint16_t level);

  /// Appends what turns `earlier` into this table; nothing where they are equal.
  void write_change(const Codebook& earlier, std::vector<std::uint8_t>& out) const;

  /// Applies a change; no bytes, no change. Fails (kCorrupt) on bytes after which levels would not ascend
  /// within the range, and leaves the table as it was.
  Result<void> read_change(std::span<const std::uint8_t> bytes);

  /// The depth that each code stands for: its level, or one between its neighbours'; beyond the first and the
  /// last level, that level. All within the range.
  std::vector<std::uint16_t> depth_of_code() const;

 private:
  int place(std::uint16_t level, int below, int above) const;
  double density(int outermost, int direction) const;
  double steps(double from, double to) const;  // sensor steps between two depths, in the stream's unit

  DepthRangeUnits range_;
  double steps_per_inverse_unit_;
  std::vector<std::uint16_t> levels_;  // kCodes of them
};

}  // namespace copresence::depth
