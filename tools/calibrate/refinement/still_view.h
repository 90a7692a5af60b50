#pragma once

// Reads a camera's recording or stream of a still scene and makes surfaces of its mean depth. The
// surfaces are the input of the commands refine and check.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "common/result.h"
#include "common/scene/scene.h"
#include "tools/calibrate/capture.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

struct StillView {
  std::string name;
  Surface surface;
  Rigid3 world_from_camera;  ///< Pose from the scene file, or else from the recording or server.
  std::optional<double> calibration_error_m;  ///< Error in the scene file, relative to the reference camera.
  double unsteady = 0;                        ///< Value of DepthAverage::unsteady_share().
};

/// Largest number of frames that are averaged, evenly spread over a recording.
inline constexpr std::size_t kFramesAveraged = 60;

/// Reads every source, in order.
/// Fails as Capture::open() does. Fails with kInvalid for a camera that is not in the scene or has
/// no pose. Fails with kCorrupt if hardly any pixel of a camera has steady depth.
Result<std::vector<StillView>> still_views(std::span<const NamedSource> sources, const scene::Scene& scene,
                                           const std::string& scene_path);

}  // namespace copresence::calibrate
