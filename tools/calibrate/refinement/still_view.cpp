#include "tools/calibrate/refinement/still_view.h"

#include <fmt/format.h>

#include "tools/calibrate/geometry/plane_depth.h"

namespace copresence::calibrate {
namespace {

constexpr double kLeastPlanar = 0.02;  // Minimum share of pixels with a plane.

Result<StillView> still_view(const NamedSource& source, const scene::Scene& scene, const scene::Camera& known,
                             const std::string& scene_path) {
  auto capture = Capture::open(source, &scene);
  if (!capture) return fail(capture.error());
  if (!capture->world_from_camera()) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "camera \"{}\" has no world_from_camera in {}: find its pose with `calibrate markers` first",
            source.name, scene_path));
  }
  DepthAverage average(capture->unit());
  const auto looked = for_each_frame(*capture, kFramesAveraged, {}, [&](const RgbdFrame& frame) {
    average.add(frame.depth);
    return std::string();
  });
  if (!looked) return fail(looked.error());
  StillView view{source.name,
                 make_surface(average.still_depth(), capture->model()),
                 *capture->world_from_camera(),
                 {},
                 average.unsteady_share()};
  if (known.calibration_error_mm) view.calibration_error_m = 1e-3 * *known.calibration_error_mm;
  const double pixels = static_cast<double>(capture->model().width) * capture->model().height;
  if (view.surface.planar < kLeastPlanar * pixels) {
    const double measured = average.measured_share(), surfaces = view.surface.planar / pixels;
    if (measured < 2 * kLeastPlanar) {
      return fail(
          ErrorCode::kCorrupt,
          fmt::format("{}: depth was measured in only {:.1f} % of the picture: turn the camera to where "
                      "something stands 0.5 to 4 m before it, or leave it out",
                      source.from, 100 * measured));
    }
    return fail(
        ErrorCode::kCorrupt,
        fmt::format(
            "{}: only {:.1f} % of the picture shows surfaces at rest; neither the camera nor the scene may "
            "move during the recording",
            source.from, 100 * surfaces));
  }
  return view;
}

}  // namespace

Result<std::vector<StillView>> still_views(std::span<const NamedSource> sources, const scene::Scene& scene,
                                           const std::string& scene_path) {
  if (const auto there = check_sources(sources, &scene); !there) return fail(there.error());
  std::vector<StillView> views;
  for (const NamedSource& source : sources) {
    const scene::Camera* known = scene.find(source.name);
    if (!known) {
      return fail(ErrorCode::kInvalid, fmt::format("{} has no camera \"{}\"", scene_path, source.name));
    }
    auto view = still_view(source, scene, *known, scene_path);
    if (!view) return fail(view.error());
    views.push_back(std::move(*view));
  }
  return views;
}

}  // namespace copresence::calibrate
