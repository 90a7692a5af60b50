#include "tools/calibrate/still_view.h"

#include <fmt/format.h>

#include "tools/calibrate/alignment/static_depth.h"

namespace copresence::calibrate {
namespace {

constexpr double kLeastPlanar = 0.02;  // share of the picture

Result<StillView> still_view(const NamedSource& source, const scene::Camera& known,
                             const std::string& scene_path) {
  auto capture = Capture::open(source, &known);
  if (!capture) return fail(capture.error());
  if (!capture->world_from_camera()) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "camera \"{}\" has no world_from_camera in {}: find its pose with `calibrate markers` first",
            source.name, scene_path));
  }
  std::vector<DepthImage> depths;
  const auto looked = look_at_frames(*capture, kFramesAveraged, {}, [&](RgbdFrame frame) {
    depths.push_back(std::move(frame.depth));
    return std::string();
  });
  if (!looked) return fail(looked.error());
  const Image<float> mean = alignment::static_depth(depths, capture->unit());
  StillView view{source.name,
                 alignment::make_surface(mean, capture->model()),
                 *capture->world_from_camera(),
                 {},
                 alignment::unsteady_share(depths, mean)};
  if (known.calibration_error_mm) view.calibration_error_m = 1e-3 * *known.calibration_error_mm;
  const double pixels = static_cast<double>(capture->model().width) * capture->model().height;
  if (view.surface.planar < kLeastPlanar * pixels) {
    const double measured = alignment::measured_share(depths), surfaces = view.surface.planar / pixels;
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
            "{}: only {:.1f} % of the picture are surfaces that keep still; neither the camera nor what "
            "it looks at may move while it records",
            source.from, 100 * surfaces));
  }
  return view;
}

}  // namespace

Result<std::vector<StillView>> still_views(std::span<const NamedSource> sources, const scene::Scene& scene,
                                           const std::string& scene_path) {
  if (const auto there = try_all(sources, &scene); !there) return fail(there.error());
  std::vector<StillView> views;
  for (const NamedSource& source : sources) {
    const scene::Camera* known = scene.find(source.name);
    if (!known) {
      return fail(ErrorCode::kInvalid, fmt::format("{} has no camera \"{}\"", scene_path, source.name));
    }
    auto view = still_view(source, *known, scene_path);
    if (!view) return fail(view.error());
    views.push_back(std::move(*view));
  }
  return views;
}

}  // namespace copresence::calibrate
