#pragma once

// A codebook assigns a code to each depth level, a depth that a sensor can report. A sensor has
// only some hundred levels. Codes ascend with depth, so a small error of a code gives a small error
// of depth.
//
// Between the known levels, as many codes are free as the sensor has disparity steps there
// (DepthNoise). So a new level usually gets a code without moving other levels. A code without a
// level stands for a depth between its neighbours' levels, evenly in 1/z. See
// docs/internals/codecs.md for the bytes of a change (codebook_change.cpp). Thread: distinct
// objects are independent.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::depth {

class Codebook {
 public:
  static constexpr int kCodes = 1024;  ///< Number of codes of a 10-bit picture.

  /// Creates a codebook without levels. Requires 1 <= range.near < range.far.
  Codebook(DepthRangeUnits range, DepthUnit unit, const DepthNoise& noise);

  /// The level of every code, ascending; 0 for a code without a level.
  std::span<const std::uint16_t> levels() const { return levels_; }
  int count() const;

  /// Returns distances in codes between neighbouring levels, for assign(). The distance is one code
  /// for each of the sensor's steps, and at least one code between levels. This spacing matches the
  /// sensor's resolution, which makes lossless coding cheapest. Source: thesis 3.3.3.2.
  std::vector<double> sensor_spacing(std::span<const std::uint16_t> levels) const;

  /// Returns distances for assign() that spend the codes on the depths in the scene. Levels with
  /// many pixels are spaced as widely as the codes allow, up to kFinest codes per step. Rare levels
  /// have one code per step. `pixels` holds each level's number of pixels. More codes per step with
  /// a coarser QP cost the same bits. But the error of H.264 is then a fraction of a level, which
  /// reduces the total error by a tenth. Source: thesis 3.3.3.3 for the idea; the formula is ours.
  std::vector<double> scene_spacing(std::span<const std::uint16_t> levels,
                                    std::span<const std::uint32_t> pixels) const;
  static constexpr double kFinest = 4.0;  ///< In codes per disparity step; finer codes gained nothing.

  /// Returns distances for assign() that are even in 1/z over the whole range, with at most kEven
  /// codes per disparity step. Levels that appear later then get codes without moving others.
  std::vector<double> even_spacing(std::span<const std::uint16_t> levels) const;

  /// Returns distances for assign() of exactly kEven codes per disparity step, beginning at the far
  /// end. The codes suffice from nearest_double() on. Nearer levels share the remaining codes.
  std::vector<double> double_spacing(std::span<const std::uint16_t> levels) const;
  /// The smallest depth with kEven codes per step in double_spacing(), in the stream's unit.
  double nearest_double() const;
  /// In codes per disparity step. A whole number gives equal steps equal distances.
  static constexpr double kEven = 2.0;

  /// Replaces all levels by `levels`. The value distance[i] is the wanted number of codes between
  /// level i and the level before it (for i = 0, the first code). Distances that do not fit are
  /// scaled down. Every level gets its own code. Requires at most kCodes levels, ascending and
  /// within the range, and as many distances.
  void assign(std::span<const std::uint16_t> levels, std::span<const double> distance);

  /// Replaces all levels by kCodes levels, even in 1/z over `range`, a part of the codebook's
  /// range. If the unit is coarse, there are fewer levels. Use this function for depth with more
  /// levels than codes.
  void assign_evenly(DepthRangeUnits range);

  /// Gives `level` a code between its neighbours' codes, and moves as few other levels as possible.
  /// Returns false if all codes are taken. Requires a level within the range that has no code yet.
  bool insert(std::uint16_t level);

  /// Appends the change that turns `earlier` into this codebook. Appends nothing if both are equal.
  void write_change(const Codebook& earlier, std::vector<std::uint8_t>& out) const;

  /// Applies a change. If `bytes` is empty, the codebook stays unchanged. Fails with kCorrupt and
  /// changes nothing if the levels would not ascend within the range afterwards.
  Result<void> read_change(std::span<const std::uint8_t> bytes);

  /// Returns the depth of each code: its level, or a depth between its neighbours' levels. Codes
  /// before the first and after the last level have the depth of that level. All depths are within
  /// the range.
  std::vector<std::uint16_t> depth_of_code() const;

 private:
  int place(std::uint16_t level, int below, int above) const;
  double density(int outermost, int direction) const;
  double steps(double from, double to) const;  // Disparity steps between two depths in the stream's unit.

  DepthRangeUnits range_;
  double steps_per_inverse_unit_;
  std::vector<std::uint16_t> levels_;  // Has kCodes entries.
};

}  // namespace copresence::depth
