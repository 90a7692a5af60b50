#include "tools/simulate_kinect/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>

#include "common/command_line/parse_errors.h"
#include "common/command_line/values.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::simulate_kinect {

tl::expected<Settings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  Settings settings;
  CLI::App app{
      "Records a simulated world with several Kinects. Writes one .oni file per camera (camera0.oni, ...), "
      "and "
      "scene.toml with the poses of the cameras. The end of the motion joins its beginning, so the "
      "recordings can "
      "be looped.",
      "simulate_kinect"};
  app.set_version_flag("--version", std::string("simulate_kinect ") + COPRESENCE_VERSION);
  const auto worlds = simulation::world_names();
  app.add_option("WORLD", settings.world, fmt::format("the simulated world: {}", fmt::join(worlds, ", ")))
      ->required()
      ->check(one_of(worlds));
  app.add_option("--cameras", settings.cameras,
                 fmt::format("number of Kinects, 1 to {}", simulation::kMostKinects))
      ->check(whole_number(1, simulation::kMostKinects))
      ->capture_default_str();
  app.add_option("--frames", settings.frames, "frames per camera, at 30 frames per second")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--out", settings.folder, "folder to write to; it is created if it does not exist")
      ->required()
      ->check(some("a folder's name"));
  app.add_flag("--overwrite", settings.overwrite, "replace existing recordings and scene.toml in the folder");
  app.add_option("--seed", settings.seed,
                 "seed of all noise, a whole number; the same seed gives the same bytes")
      ->check(whole_number(std::numeric_limits<decltype(settings.seed)>::min(),
                           std::numeric_limits<decltype(settings.seed)>::max()))
      ->capture_default_str();
  add_size(app, "--size", settings.width, settings.height, {16, 4096},
           "size of the pictures in pixels, WIDTHxHEIGHT");
  app.add_option("--unit", settings.unit, "depth unit of the recordings: mm or 0.1mm (default mm)")
      ->transform(one_of<DepthUnit>({{"mm", DepthUnit::kMillimetre}, {"0.1mm", DepthUnit::k100Micrometres}}));
  app.add_option("--jpeg-quality", settings.jpeg_quality, "quality of the colour pictures, 1 to 100")
      ->check(whole_number(1, 100))
      ->capture_default_str();
  auto* truth =
      app.add_option("--truth", settings.truth_views,
                     "also write the true depth (16-bit PNG, 0.1 mm along the optical axis, 0 = none "
                     "or beyond 6.5535 m) and true colour (PNG) of each camera to truth/NAME/. Path "
                     "files add viewpoints; their lines are \"view x y z look_x look_y look_z\" in "
                     "metres")
          ->expected(0, 64)
          ->check(existing_file());
  add_size(app, "--truth-size", settings.truth_width, settings.truth_height, {16, 4096},
           "size of the pictures of additional viewpoints");
  app.add_option("--truth-fov", settings.truth_fov_deg,
                 "vertical field of view of additional viewpoints, degrees")
      ->check(number(1, 170))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(report_parse_error(app, error));
  }
  settings.truth = truth->count() > 0;
  // CLI11 passes an empty value for an option without values.
  std::erase_if(settings.truth_views, [](const auto& path) { return path.empty(); });
  return settings;
}

}  // namespace copresence::simulate_kinect
