#pragma once

// A camera's recording or stream as the surfaces it saw all along: what refine and check work on.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "common/result.h"
#include "common/scene/scene.h"
#include "tools/calibrate/alignment/surface.h"
#include "tools/calibrate/capture.h"

namespace copresence::calibrate {

struct StillView {
  std::string name;
  alignment::Surface surface;
  Rigid3 world_from_camera;  ///< the scene's, else the recording's or server's own
  std::optional<double>
      calibration_error_m;  ///< the scene's: what a shift to the reference camera is known to
  double unsteady = 0;      ///< share of what it measured that did not keep still
};

/// At most this many frames of a camera are averaged, spread evenly over a recording.
inline constexpr std::size_t kFramesAveraged = 60;

/// Reads every source, in their order.
/// Fails  as Capture::open() does, kInvalid for a camera that the scene does not have or that has no pose, kCorrupt
///        for a camera of which hardly any pixel keeps still.
Result<std::vector<StillView>> still_views(std::span<const NamedSource> sources, const scene::Scene& scene,
                                           const std::string& scene_path);

}  // namespace copresence::calibrate
