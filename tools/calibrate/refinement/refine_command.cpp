#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/command_line/values.h"
#include "common/scene/scene.h"
#include "common/scene/write_scene.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/pictures.h"
#include "tools/calibrate/refinement/refinement.h"
#include "tools/calibrate/refinement/still_view.h"
#include "tools/calibrate/report.h"

namespace copresence::calibrate {
namespace {

using Outcome = CameraRefinement::Outcome;

// Smallest error that a scene file can store: a tenth of a millimetre.
constexpr double kLeastError_m = 1e-4;

// Largest StillView::unsteady of a still room. Edges and flicker alone cause a fifth of this value.
constexpr double kUnsteady = 0.02;

struct Options {
  std::string scene, out, json, picture;
  std::vector<NamedSource> sources;
  bool overwrite = false;
};

// Known error of a camera's pose relative to the first camera, metres; 0 if the scene file has
// none. Errors in the file are relative to the reference camera of `calibrate markers`.
double error_to(const StillView& first, const StillView& view) {
  if (!view.calibration_error_m) return 0;
  return std::max(kLeastError_m,
                  std::hypot(*view.calibration_error_m, first.calibration_error_m.value_or(0)));
}

// Draws how the surfaces of each pair of cameras agree before and after refinement.
Result<void> show(const Refinement& refinement, std::span<const StillView> views, const std::string& file) {
  std::vector<SurfaceComparison> all;
  for (const PairRefinement& pair : refinement.pairs) {
    const StillView &a = views[pair.a], &b = views[pair.b];
    const std::string who = fmt::format("{} against {}", a.name, b.name);
    all.push_back({fmt::format("{}, before: median {:.1f} mm", who, 1000 * pair.before.median_m), a.surface,
                   a.world_from_camera, b.surface, b.world_from_camera});
    all.push_back({fmt::format("after: median {:.1f} mm", 1000 * pair.after.median_m), a.surface,
                   refinement.cameras[pair.a].world_from_camera, b.surface,
                   refinement.cameras[pair.b].world_from_camera});
  }
  return write_agreement_picture(all, file);
}

Result<void> run(const Options& options) {
  if (auto kept = refuse_existing({options.json, options.picture}, options.overwrite); !kept) return kept;
  if (auto other = refuse_other_than_scene(options.out, options.overwrite); !other) return other;
  auto scene = scene::load(options.scene);
  if (!scene) return fail(scene.error());
  const auto views = still_views(options.sources, *scene, options.scene);
  if (!views) return fail(views.error());
  std::vector<Surface> surfaces;
  std::vector<Rigid3> poses;
  std::vector<double> errors_m;
  for (const StillView& view : *views) {
    surfaces.push_back(view.surface);
    poses.push_back(view.world_from_camera);
    errors_m.push_back(error_to(views->front(), view));
  }
  Refinement refinement = refine(surfaces, poses, errors_m);
  for (const PairRefinement& pair : refinement.pairs) {
    fmt::print("{} - {}\n  before  {}\n  after   {}\n", (*views)[pair.a].name, (*views)[pair.b].name,
               to_text(pair.before), to_text(pair.after));
    const std::string wrong = problem_of(pair.after, {});
    if (wrong.empty()) continue;
    fmt::print("  still not good: {}; were the given poses more than 10 cm or 5 degrees off?\n", wrong);
    for (const std::size_t i : {pair.a, pair.b})
      refinement.cameras[i].error_mm = 0;  // The estimate holds only near the right pose.
  }
  bool any = false;
  for (std::size_t i = 0; i < views->size(); ++i) {
    const CameraRefinement& camera = refinement.cameras[i];
    fmt::print("{}: {}\n", (*views)[i].name, to_text(camera));
    if ((*views)[i].unsteady > kUnsteady) {
      fmt::print(
          "{}: {:.1f} % of its pixels did not keep still; if a person moved, errors can be several times "
          "larger "
          "than expected: record again while nobody moves\n",
          (*views)[i].name, 100 * (*views)[i].unsteady);
    }
    any = any || (camera.outcome != Outcome::kReference && camera.outcome != Outcome::kNoOverlap);
  }
  if (!options.json.empty()) {
    if (auto written = write_json(to_json(refinement, *views), options.json); !written) return written;
  }
  if (!options.picture.empty()) {
    if (auto shown = show(refinement, *views, options.picture); !shown) return shown;
  }
  if (!any) {
    return fail(ErrorCode::kRefused, fmt::format("the cameras share less than {:.0f} % of their surfaces, "
                                                 "which is too little; {} is not written: turn "
                                                 "the cameras so that they see more of the same surfaces",
                                                 100 * kLeastOverlap, options.out));
  }
  for (std::size_t i = 0; i < views->size(); ++i) {
    if (refinement.cameras[i].outcome != Outcome::kRefined) continue;
    for (scene::Camera& camera : scene->cameras) {
      if (camera.name != (*views)[i].name) continue;
      camera.world_from_camera = refinement.cameras[i].world_from_camera;
      const double error_mm =
          std::max(1000 * kLeastError_m, std::round(10 * refinement.cameras[i].error_mm) / 10);
      camera.calibration_error_mm =
          refinement.cameras[i].error_mm > 0 ? std::optional(error_mm) : std::nullopt;
    }
  }
  return scene::save(*scene, options.out, options.scene);
}

}  // namespace

Command refine_command(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "refine",
      "Refines the poses of all cameras on the surfaces that they see in common. The first camera does not "
      "move. Nothing may move while you record; moving objects are left out. Prints the distance between the "
      "surfaces of each pair before and after, in mm and in units of the sensors' noise. Exit code 0: the "
      "poses are at least as good as before; 1: the cameras see too little in common.");
  const auto options = std::make_shared<Options>();
  parser
      ->add_option("--scene", options->scene,
                   "the scene file with initial poses, at most 10 cm and 5 degrees off")
      ->required()
      ->check(command_line::file_name());
  add_source_options(*parser, options->sources, 2, 64);
  parser->add_option("--out", options->out, "the scene file to write; may be the same")
      ->required()
      ->check(command_line::replaceable_file());
  parser->add_option("--json", options->json, "also write the report as JSON")
      ->check(command_line::writable_file());
  parser
      ->add_option(
          "--picture", options->picture,
          "write coloured pictures of the distances between surfaces, before and after (.png or .jpg)")
      ->check(picture_file_name());
  add_overwrite(*parser, options->overwrite);
  return {parser, [options] { return run(*options); }};
}

}  // namespace copresence::calibrate
