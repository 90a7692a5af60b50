#include <fmt/format.h>

#include <memory>

#include "common/command_line/values.h"
#include "common/scene/scene.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/pictures.h"
#include "tools/calibrate/refinement/association.h"
#include "tools/calibrate/refinement/still_view.h"
#include "tools/calibrate/report.h"

namespace copresence::calibrate {
namespace {

struct Options {
  std::string scene, json, picture;
  std::vector<NamedSource> sources;
  Limits limits;
  bool overwrite = false;
};

Result<void> run(const Options& options) {
  if (auto kept = refuse_existing({options.json, options.picture}, options.overwrite); !kept) return kept;
  const auto scene = scene::load(options.scene);
  if (!scene) return fail(scene.error());
  const auto views = still_views(options.sources, *scene, options.scene);
  if (!views) return fail(views.error());
  nlohmann::json pairs = nlohmann::json::array();
  std::vector<SurfaceComparison> seen;
  std::string wrong;
  int judged = 0;
  for (std::size_t i = 0; i < views->size(); ++i) {
    for (std::size_t j = i + 1; j < views->size(); ++j) {
      const StillView &a = (*views)[i], &b = (*views)[j];
      const Agreement agreement =
          measure_agreement(a.surface, a.world_from_camera, b.surface, b.world_from_camera);
      const bool judges = is_judged(agreement);
      const std::string problem = problem_of(agreement, options.limits);
      const std::string verdict =
          !judges           ? fmt::format("not judged: under {:.0f} % in common", 100 * kLeastJudged)
          : problem.empty() ? "good"
                            : problem;
      fmt::print("{} - {}\n  {}\n  {}\n", a.name, b.name, to_text(agreement), verdict);
      nlohmann::json entry = to_json(agreement);
      entry.update({{"a", a.name}, {"b", b.name}, {"good", judges && problem.empty()}, {"verdict", verdict}});
      pairs.push_back(std::move(entry));
      if (judges) {
        seen.push_back({fmt::format("{} against {}", a.name, b.name), a.surface, a.world_from_camera,
                        b.surface, b.world_from_camera});
        seen.push_back({fmt::format("{} against {}", b.name, a.name), b.surface, b.world_from_camera,
                        a.surface, a.world_from_camera});
      }
      judged += judges;
      if (wrong.empty() && !problem.empty()) wrong = fmt::format("{} and {}: {}", a.name, b.name, problem);
    }
  }
  const bool good = wrong.empty() && judged > 0;
  if (!options.json.empty()) {
    const nlohmann::json report{{"pairs", pairs},
                                {"good", good},
                                {"limits",
                                 {{"median_sigmas", options.limits.most_median_sigmas},
                                  {"median_mm", options.limits.most_median_mm},
                                  {"contradicted_percent", options.limits.most_contradicted_percent},
                                  {"least_overlap", kLeastJudged}}}};
    if (auto written = write_json(report, options.json); !written) return written;
  }
  if (!options.picture.empty()) {
    if (auto written = write_agreement_picture(seen, options.picture); !written) return written;
  }
  if (!wrong.empty()) {
    return fail(ErrorCode::kRefused,
                wrong + "; run `calibrate refine`, and `calibrate markers` if that does not help");
  }
  if (!judged) {
    return fail(ErrorCode::kRefused, "no two cameras see enough of the same surfaces to judge their poses");
  }
  return {};
}

}  // namespace

Command check_command(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "check",
      "Prints and judges the distance between the surfaces of each pair of cameras. Exit code 0: all pairs "
      "that overlap are good; 1: one is not, or no pair overlaps.");
  const auto options = std::make_shared<Options>();
  parser->add_option("--scene", options->scene, "the scene file with the cameras' poses")
      ->required()
      ->check(command_line::file_name());
  add_source_options(*parser, options->sources, 2, 64);
  parser->add_option("--json", options->json, "also write the report as JSON")
      ->check(command_line::writable_file());
  parser
      ->add_option("--picture", options->picture,
                   "write coloured pictures of the distances between surfaces (.png or .jpg)")
      ->check(picture_file_name());
  parser
      ->add_option("--most-sigmas", options->limits.most_median_sigmas,
                   "largest good median distance, in units of the sensors' noise")
      ->capture_default_str()
      ->check(command_line::number_above_zero(1e6));
  parser->add_option("--most-mm", options->limits.most_median_mm, "largest good median distance, mm")
      ->capture_default_str()
      ->check(command_line::number_above_zero(1e6));
  parser
      ->add_option("--most-contradicted", options->limits.most_contradicted_percent,
                   "largest good share of points that the other camera sees through, percent")
      ->capture_default_str()
      ->check(command_line::number(0, 100));
  add_overwrite(*parser, options->overwrite);
  return {parser, [options] { return run(*options); }};
}

}  // namespace copresence::calibrate
