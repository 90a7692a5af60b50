#pragma once

// A codebook assigns a code to each of a sensor's depth levels. A depth sensor reports only some
// hundred distances. Codes ascend with depth. So a code that lossy coding has changed a little
// gives a depth that is slightly wrong.
//
// Between the known levels, codes are left free: as many as the sensor has disparity steps there
// (DepthNoise). A level that is found later then mostly gets a code without moving another level. A
// code without a level stands for a depth between its neighbours' levels, evenly in 1/z.
//
// The bytes of a change are described in docs/internals/codecs.md (codebook_change.cpp). Thread: a
// value.

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
  Codebook(DepthRangeUnits range, DepthUnit unit, const DepthNoise& noise);

  /// The level of every code, ascending; 0 for a code without a level.
  std::span<const std::uint16_t> levels() const { return levels_; }
  int count() const;

  /// Distances in codes between neighbouring levels, for assign(): one code for each of the
  /// sensor's steps, and at least one between levels. This is as fine as the sensor and no finer,
  /// which makes lossless coding cheapest.
  /// Source: thesis 3.3.3.2.
  std::vector<double> sensor_spacing(std::span<const std::uint16_t> levels) const;

  /// Distances for assign() that spend the codes on the depths in the scene. Levels that many
  /// pixels have are spaced as widely as the codes allow, up to kFinest codes a step. Rare levels
  /// are one code a step apart. A finer code and a coarser QP cost the same bits, but H.264 then
  /// errs by fractions of a level: a tenth less error at the same rate. `pixels` holds how many
  /// pixels each level has. Source: thesis 3.3.3.3 for the purpose; the form is ours.
  std::vector<double> scene_spacing(std::span<const std::uint16_t> levels,
                                    std::span<const std::uint32_t> pixels) const;
  static constexpr double kFinest = 4.0;  ///< codes a step; finer ones gained nothing

  /// Replaces all levels by these. distance[i] is the number of codes wanted between level i and
  /// the level before it, or the first code. Distances that do not fit are scaled down; every level
  /// gets a code of its own.
  /// Requires levels ascending, within the range, at most kCodes, and as many distances.
  void assign(std::span<const std::uint16_t> levels, std::span<const double> distance);

  /// Replaces all levels by kCodes levels, even in 1/z over a part of the codebook's range. There
  /// are fewer levels if the unit is too coarse for so many. Meant for depth that has more levels
  /// than codes.
  void assign_evenly(DepthRangeUnits range);

  /// Gives `level` a code between its neighbours' codes, and moves as few other levels as possible.
  /// Returns false if all codes are taken. Requires a level within the range that has no code yet.
  bool insert(std::uint16_t level);

  /// Appends the change that turns `earlier` into this codebook; appends nothing if they are equal.
  void write_change(const Codebook& earlier, std::vector<std::uint8_t>& out) const;

  /// Applies a change; no bytes mean no change. Fails (kCorrupt) and changes nothing if the levels
  /// would not ascend within the range afterwards.
  Result<void> read_change(std::span<const std::uint8_t> bytes);

  /// The depth of each code: its level, or a depth between its neighbours' levels. Codes beyond the
  /// first and the last level have that level. All depths are within the range.
  std::vector<std::uint16_t> depth_of_code() const;

 private:
  int place(std::uint16_t level, int below, int above) const;
  double density(int outermost, int direction) const;
  double steps(double from, double to) const;  // disparity steps between two depths in the stream's unit

  DepthRangeUnits range_;
  double steps_per_inverse_unit_;
  std::vector<std::uint16_t> levels_;  // kCodes of them
};

}  // namespace copresence::depth
