#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/command_line/values.h"
#include "common/scene/scene.h"
#include "common/scene/write_scene.h"
#include "tools/calibrate/agreement_picture.h"
#include "tools/calibrate/alignment/refinement.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/picture_file.h"
#include "tools/calibrate/report.h"
#include "tools/calibrate/shared_options.h"
#include "tools/calibrate/still_view.h"

namespace copresence::calibrate {
namespace {

using alignment::CameraRefinement;
using Outcome = CameraRefinement::Outcome;

// Scene files tell tenths of a millimetre.
constexpr double kLeastError_m = 1e-4;

constexpr double kUnsteady =
    0.02;  // share of what a camera measured; rims and flicker alone come to a fifth of that

struct Options {
  std::string scene, out, json, picture;
  std::vector<NamedSource> sources;
  bool overwrite = false;
};

std::string_view name(Outcome outcome) {
  switch (outcome) {
    case Outcome::kReference:
      return "reference";
    case Outcome::kRefined:
      return "refined";
    case Outcome::kKept:
    case Outcome::kKnownBetter:
    case Outcome::kNotConfirmed:
      return "kept";
    case Outcome::kNoOverlap:
      return "no_overlap";
  }
  return "";
}

std::string describe(const alignment::Direction& direction) {
  const auto list = [](const Eigen::Vector3d& v) {
    return fmt::format("{:.2f} {:.2f} {:.2f}", v.x(), v.y(), v.z());
  };
  const bool shifts = direction.shift.norm() > 0.3, turns = direction.turn.norm() > 0.3;
  if (shifts && turns) {
    return fmt::format("a shift along ({}) with a turn about ({})", list(direction.shift),
                       list(direction.turn));
  }
  return turns ? fmt::format("a turn about ({})", list(direction.turn))
               : fmt::format("a shift along ({})", list(direction.shift));
}

std::string tell(const CameraRefinement& camera) {
  switch (camera.outcome) {
    case Outcome::kReference:
      return "the reference, not moved";
    case Outcome::kKept:
      return "kept as given: the surfaces agree better so than in any pose found nearby";
    case Outcome::kKnownBetter:
      return fmt::format(
          "kept as given: it is known to {:.1f} mm, and the surfaces alone tell it to {:.1f} mm only",
          camera.told_mm, camera.surfaces_mm);
    case Outcome::kNotConfirmed:
      return fmt::format(
          "kept as given, known to {:.1f} mm: surfaces that had no part in the fit agree no better where it "
          "puts the camera",
          camera.told_mm);
    case Outcome::kNoOverlap:
      return fmt::format(
          "kept as given: it has less than {:.0f} % in common with the others; turn the cameras so that "
          "they see more of the same surfaces, or add markers",
          100 * alignment::kLeastOverlap);
    case Outcome::kRefined:
      break;
  }
  std::string text = fmt::format("moved {:.1f} mm and {:.2f} degrees", camera.moved_mm, camera.moved_deg);
  text += camera.error_mm > 0 ? fmt::format(", expected to be {:.1f} mm off now", camera.error_mm)
                              : ", how far off it is now nobody knows";
  if (camera.contradicts_told) {
    text += fmt::format(
        "; the surfaces lie farther from the given pose than its error of {:.1f} mm explains, so it was "
        "trusted less: has the camera been touched since the markers were seen?",
        camera.told_mm);
  }
  for (const alignment::Direction& direction : camera.unsupported) {
    text += fmt::format(
        "; nothing in the overlap resists {}, so that part is as given: put something with corners "
        "where both cameras see it",
        describe(direction));
  }
  return text;
}

nlohmann::json matrix(const Rigid3& pose) {
  nlohmann::json rows = nlohmann::json::array();
  const Eigen::Matrix4d m = pose.matrix();
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

nlohmann::json to_json(const alignment::Refinement& refinement, std::span<const StillView> views) {
  nlohmann::json cameras = nlohmann::json::array(), pairs = nlohmann::json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CameraRefinement& camera = refinement.cameras[i];
    nlohmann::json unsupported = nlohmann::json::array();
    for (const alignment::Direction& direction : camera.unsupported) {
      unsupported.push_back({{"turn", {direction.turn.x(), direction.turn.y(), direction.turn.z()}},
                             {"shift", {direction.shift.x(), direction.shift.y(), direction.shift.z()}},
                             {"resistance", direction.resistance}});
    }
    cameras.push_back({{"name", views[i].name},
                       {"unsteady", views[i].unsteady},
                       {"outcome", name(camera.outcome)},
                       {"says", tell(camera)},
                       {"moved_mm", camera.moved_mm},
                       {"moved_deg", camera.moved_deg},
                       {"told_mm", camera.told_mm},
                       {"surfaces_mm", camera.surfaces_mm},
                       {"error_mm", camera.error_mm},
                       {"contradicts_told", camera.contradicts_told},
                       {"unsupported", unsupported},
                       {"world_from_camera", matrix(camera.world_from_camera)}});
  }
  for (const alignment::PairRefinement& pair : refinement.pairs) {
    pairs.push_back({{"a", views[pair.a].name},
                     {"b", views[pair.b].name},
                     {"before", calibrate::to_json(pair.before)},
                     {"after", calibrate::to_json(pair.after)}});
  }
  return {{"cameras", cameras}, {"pairs", pairs}, {"least_resistance", refinement.least_resistance}};
}

// How well a camera's pose is known against the first one's, metres; 0 where the scene file does not tell. What it tells
// is against the camera that was the reference then, whose own error is 0.
double error_to(const StillView& first, const StillView& view) {
  if (!view.calibration_error_m) return 0;
  return std::max(kLeastError_m,
                  std::hypot(*view.calibration_error_m, first.calibration_error_m.value_or(0)));
}

// Each pair's first camera against the second, before and after.
Result<void> show(const alignment::Refinement& refinement, std::span<const StillView> views,
                  const std::string& file) {
  std::vector<SeenAgainst> all;
  for (const alignment::PairRefinement& pair : refinement.pairs) {
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
  if (auto kept = keep_existing({options.json, options.picture}, options.overwrite); !kept) return kept;
  if (auto other = keep_other_than_scene(options.out, options.overwrite); !other) return other;
  auto scene = scene::load(options.scene);
  if (!scene) return fail(scene.error());
  const auto views = still_views(options.sources, *scene, options.scene);
  if (!views) return fail(views.error());
  std::vector<alignment::Surface> surfaces;
  std::vector<Rigid3> poses;
  std::vector<double> errors_m;
  for (const StillView& view : *views) {
    surfaces.push_back(view.surface);
    poses.push_back(view.world_from_camera);
    errors_m.push_back(error_to(views->front(), view));
  }
  alignment::Refinement refinement = alignment::refine(surfaces, poses, errors_m);
  for (const alignment::PairRefinement& pair : refinement.pairs) {
    fmt::print("{} - {}\n  before  {}\n  after   {}\n", (*views)[pair.a].name, (*views)[pair.b].name,
               to_text(pair.before), to_text(pair.after));
    const std::string wrong = complaint(pair.after, {});
    if (wrong.empty()) continue;
    fmt::print("  still not good: {}; were the poses given more than 10 cm or 5 degrees off?\n", wrong);
    for (const std::size_t i : {pair.a, pair.b})
      refinement.cameras[i].error_mm = 0;  // it is in another place
  }
  bool any = false;
  for (std::size_t i = 0; i < views->size(); ++i) {
    const CameraRefinement& camera = refinement.cameras[i];
    fmt::print("{}: {}\n", (*views)[i].name, tell(camera));
    if ((*views)[i].unsteady > kUnsteady) {
      fmt::print(
          "{}: {:.1f} % of what it measured did not keep still; what somebody who moves leaves behind can "
          "put "
          "poses several times farther off than they are expected to be: record again when nobody moves\n",
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
    return fail(
        ErrorCode::kRefused,
        fmt::format(
            "the cameras have less than {:.0f} % of their surfaces in common, too little to refine on; "
            "{} is not written: turn the cameras so that they see more of the same surfaces",
            100 * alignment::kLeastOverlap, options.out));
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
      "Refines the cameras' poses on the surfaces that they see in common, all at once; the first camera "
      "stays. Nothing "
      "may move while the recordings are made; what moves all the same is left out. Tells for each pair of "
      "cameras how "
      "far surfaces lie apart before and after, in mm and in units of the sensors' expected noise. Leaves "
      "with 0 when "
      "the poses are at least as good as before, with 1 when the cameras see too little in common.");
  const auto options = std::make_shared<Options>();
  parser
      ->add_option("--scene", options->scene,
                   "the scene file with poses to start from, up to 10 cm and 5 degrees off")
      ->required()
      ->check(command_line::file_name());
  add_source_options(*parser, options->sources, 2, 64);
  parser->add_option("--out", options->out, "the scene file to write; may be the same")
      ->required()
      ->check(command_line::replaceable_file());
  parser->add_option("--json", options->json, "also tells everything to this file")
      ->check(command_line::writable_file());
  parser
      ->add_option("--picture", options->picture,
                   "write how far surfaces lie apart, before and after, as coloured pictures (.png or .jpg)")
      ->check(picture_file_name());
  add_overwrite(*parser, options->overwrite);
  return {parser, [options] { return run(*options); }};
}

}  // namespace copresence::calibrate
