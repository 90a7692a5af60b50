#pragma once

// Simulated rooms, recorded by simulated Kinects and rendered by the client's renderer without
// video coding. Thread: one thread.

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "tools/view_bench/view_error.h"

namespace copresence::view_bench {

/// Names of the scenes, which differ in the person's motion, the number of cameras and the
/// viewpoint.
std::vector<std::string_view> scene_names();

struct RunSettings {
  int width = 640, height = 360;
  double fov_degrees = 50;
  /// Number of views, at 30 per second or at 60 if the cameras take turns. The first second is not
  /// scored, because filters settle.
  int frames = 60;
  renderer::UnseenStyle unseen{.show = renderer::UnseenStyle::Show::kExtend};
  /// Folder for PNG files of the last view and its ground truth; empty for none.
  std::string pictures;
};

struct SceneResult {
  ViewScore score;
  /// PSNR over the pixels of moving regions that the best single camera sees: if that camera alone
  /// shows them, and if all cameras do. NaN unless the cameras take turns.
  double psnr_alone = 0, psnr_together = 0;
};

/// Requires one of scene_names(). Fails if the simulator, the hole filler or the renderer fails.
Result<SceneResult> run_scene(std::string_view name, const RunSettings& settings);

}  // namespace copresence::view_bench
