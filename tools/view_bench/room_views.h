#pragma once

// Simulated rooms, as simulated Kinects record them and as the client's renderer shows them, without coding.
//
// Thread: one thread.

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "tools/view_bench/view_error.h"

namespace copresence::view_bench {

/// empty, standing, walking, four: what moves in the room, and how many cameras look.
std::vector<std::string_view> scene_names();

struct RunSettings {
  int width = 640, height = 360;
  double fov_degrees = 50;
  int frames = 60;  ///< at 30 per second; the first second is not scored, so that filters settle
  renderer::UnseenStyle unseen{.show = renderer::UnseenStyle::Show::kExtend};
  std::string pictures;  ///< folder for the last view and its truth as PNG; empty for none
};

/// Fails as the simulator, the hole filler and the renderer do. Requires one of scene_names().
Result<ViewScore> run_scene(std::string_view name, const RunSettings& settings);

}  // namespace copresence::view_bench
