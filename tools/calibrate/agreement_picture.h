#pragma once

// Surfaces as one camera sees them, coloured by how far off another camera puts them: what `check` and `refine` show.
// Thread: pure, but for the file.

#include <filesystem>
#include <span>
#include <string>

#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/alignment/surface.h"

namespace copresence::calibrate {

/// One camera's surfaces against another's. References stay with the caller.
struct SeenAgainst {
  std::string label;
  const alignment::Surface& surface;
  Rigid3 world_from_camera;
  const alignment::Surface& other;
  Rigid3 world_from_other;
};

inline constexpr double kFullColor_mm = 20;

/// Two to a row, with a scale below: green where both cameras put a surface in one place, red where the other's lies
/// kFullColor_mm or more behind it, blue where it lies before it, pink where the other looks through it, grey where
/// the other sees nothing of it.
/// Fails  kInvalid where the name's end is that of no picture, kUnavailable where it cannot be written.
Result<void> write_agreement_picture(std::span<const SeenAgainst> all, const std::filesystem::path& file);

}  // namespace copresence::calibrate
