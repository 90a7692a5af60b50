#include <fmt/format.h>

#include <memory>

#include "common/command_line/values.h"
#include "common/scene/scene.h"
#include "tools/calibrate/agreement_picture.h"
#include "tools/calibrate/alignment/agreement.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/picture_file.h"
#include "tools/calibrate/report.h"
#include "tools/calibrate/shared_options.h"
#include "tools/calibrate/still_view.h"

namespace copresence::calibrate {
namespace {

struct Options {
  std::string scene, json, picture;
  std::vector<NamedSource> sources;
  Limits limits;
  bool overwrite = false;
};

Result<void> run(const Options& options) {
  if (auto kept = keep_existing({options.json, options.picture}, options.overwrite); !kept) return kept;
  const auto scene = scene::load(options.scene);
  if (!scene) return fail(scene.error());
  const auto views = still_views(options.sources, *scene, options.scene);
  if (!views) return fail(views.error());
  nlohmann::json pairs = nlohmann::json::array();
  std::vector<SeenAgainst> seen;
  std::string wrong;
  int judged = 0;
  for (std::size_t i = 0; i < views->size(); ++i) {
    for (std::size_t j = i + 1; j < views->size(); ++j) {
      const StillView &a = (*views)[i], &b = (*views)[j];
      const alignment::Agreement agreement =
          alignment::measure_agreement(a.surface, a.world_from_camera, b.surface, b.world_from_camera);
      const bool judges = says_something(agreement);
      const std::string problem = complaint(agreement, options.limits);
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
    const nlohmann::json told{{"pairs", pairs},
                              {"good", good},
                              {"limits",
                               {{"median_sigmas", options.limits.most_median_sigmas},
                                {"median_mm", options.limits.most_median_mm},
                                {"contradicted_percent", options.limits.most_contradicted_percent},
                                {"least_overlap", kLeastJudged}}}};
    if (auto written = write_json(told, options.json); !written) return written;
  }
  if (!options.picture.empty()) {
    if (auto written = write_agreement_picture(seen, options.picture); !written) return written;
  }
  if (!wrong.empty()) {
    return fail(ErrorCode::kRefused,
                wrong + "; run `calibrate refine`, and `calibrate markers` where that does not help");
  }
  if (!judged) {
    return fail(ErrorCode::kRefused,
                "no two cameras see enough of the same surfaces to tell how good their poses are");
  }
  return {};
}

}  // namespace

Command check_command(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "check",
      "Says for each pair of cameras how far apart they see the surfaces that both see, and judges it. "
      "Leaves with 0 "
      "when every pair that overlaps is good, with 1 when one is not or none overlaps.");
  const auto options = std::make_shared<Options>();
  parser->add_option("--scene", options->scene, "the scene file with the cameras' poses")
      ->required()
      ->check(command_line::file_name());
  add_source_options(*parser, options->sources, 2, 64);
  parser->add_option("--json", options->json, "also tells everything to this file")
      ->check(command_line::writable_file());
  parser
      ->add_option("--picture", options->picture,
                   "write how far surfaces of each pair lie apart as coloured pictures (.png or .jpg)")
      ->check(picture_file_name());
  parser
      ->add_option("--most-sigmas", options->limits.most_median_sigmas,
                   "largest good median, in units of the sensors' expected noise")
      ->capture_default_str()
      ->check(command_line::number_above_zero(1e6));
  parser->add_option("--most-mm", options->limits.most_median_mm, "largest good median, mm")
      ->capture_default_str()
      ->check(command_line::number_above_zero(1e6));
  parser
      ->add_option("--most-contradicted", options->limits.most_contradicted_percent,
                   "largest good share of points of one camera where another sees through, percent")
      ->capture_default_str()
      ->check(command_line::number(0, 100));
  add_overwrite(*parser, options->overwrite);
  return {parser, [options] { return run(*options); }};
}

}  // namespace copresence::calibrate
