#include "tools/simulate_kinect/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>

#include "capture_server/simulation/simulated_kinect.h"

namespace copresence::simulate_kinect {
namespace {

/// "WxH"; empty when understood, else what is wrong.
std::string parse_size(const std::string& text, int& width, int& height) {
  const auto cross = text.find('x');
  if (cross == std::string::npos || !CLI::detail::lexical_cast(text.substr(0, cross), width) ||
      !CLI::detail::lexical_cast(text.substr(cross + 1), height)) {
    return fmt::format("\"{}\" is not WIDTHxHEIGHT in pixels, such as 640x480", text);
  }
  if (width < 16 || width > 4096 || height < 16 || height > 4096 || width % 2 != 0 || height % 2 != 0) {
    return fmt::format("{}x{} cannot be a size: both must be even, from 16 to 4096", width, height);
  }
  return {};
}

}  // namespace

tl::expected<Settings, int> read_command_line(int argc, const char* const* argv) {
  Settings settings;
  CLI::App app{
      "Renders a simulated world as several Kinects would record it: one .oni file per camera (camera0.oni, "
      "...) "
      "and scene.toml, which says where they stand. The motion closes at the recording's end.",
      "simulate_kinect"};
  app.set_version_flag("--version", std::string("simulate_kinect ") + COPRESENCE_VERSION);
  const auto worlds = simulation::World::names();
  app.add_option("WORLD", settings.world, fmt::format("the world: {}", fmt::join(worlds, ", ")))
      ->required()
      ->check(CLI::IsMember(worlds));
  app.add_option("--cameras", settings.cameras,
                 fmt::format("number of Kinects, 1 to {}", simulation::kMostKinects))
      ->check(CLI::Range(1, simulation::kMostKinects))
      ->capture_default_str();
  app.add_option("--frames", settings.frames, "frames per camera, at 30 a second")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--out", settings.folder, "folder to write to; made when it is not there")->required();
  app.add_option("--seed", settings.seed,
                 "whole number that decides all noise; the same seed gives the same bytes")
      ->capture_default_str();
  std::string size = "640x480", truth_size = "1280x720";
  app.add_option("--size", size, "pixels of the cameras' pictures, WIDTHxHEIGHT, both even")
      ->check([&](const std::string& text) { return parse_size(text, settings.width, settings.height); })
      ->capture_default_str();
  app.add_option("--unit", settings.unit, "depth unit of the recordings: mm or 0.1mm (default mm)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, DepthUnit>{
          {"mm", DepthUnit::kMillimetre}, {"0.1mm", DepthUnit::k100Micrometres}}));
  app.add_option("--jpeg-quality", settings.jpeg_quality, "of the colour pictures, 1 to 100")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  auto* truth = app.add_option("--truth", settings.truth_views,
                               "also write true depth (16-bit PNG, 0.1 mm along the optical axis, 0 = none "
                               "or beyond 6.5535 m) and true colour (PNG) of each "
                               "camera into truth/NAME/, and of further viewpoints: path files with lines "
                               "\"view x y z look_x look_y look_z\" (metres)")
                    ->expected(0, 64)
                    ->check(CLI::ExistingFile);
  app.add_option("--truth-size", truth_size, "pixels of the further viewpoints' pictures")
      ->check([&](const std::string& text) {
        return parse_size(text, settings.truth_width, settings.truth_height);
      })
      ->capture_default_str();
  app.add_option("--truth-fov", settings.truth_fov_deg, "their vertical field of view, degrees")
      ->check(CLI::Range(1.0, 170.0))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(app.exit(error) == 0 ? 0 : 2);
  }
  settings.truth = truth->count() > 0;
  // CLI11 gives a flag without values one that is empty.
  std::erase_if(settings.truth_views, [](const auto& path) { return path.empty(); });
  return settings;
}

}  // namespace copresence::simulate_kinect
