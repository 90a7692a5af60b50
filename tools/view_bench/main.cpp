#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/command_line/parse_errors.h"
#include "common/command_line/values.h"
#include "common/version.h"
#include "tools/view_bench/room_views.h"

namespace copresence::view_bench {
namespace {

constexpr const char* kDescription =
    "Compares rendered views of simulated rooms with the ground truth, over all pixels that some camera "
    "could have shown.\n"
    "Pixels that show nothing count as black. A pixel is seen, remembered (rem.), extended (ext.) or empty. "
    "PSNR is in dB, also for pixels near depth edges (edges) and in moving regions (moving). In the scene "
    "waving, the cameras take their pictures half a frame period apart. The columns alone and both then "
    "compare the best single camera with both cameras, over the moving pixels that this camera sees. Recall "
    "is the share of remembered pixels among those that a camera saw only earlier. Flicker and seam step are "
    "in 1/255.";

// JSON has no value for "not a number".
nlohmann::json finite(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json to_json(const std::string& scene, const SceneResult& result) {
  const ViewScore& score = result.score;
  return {{"scene", scene},
          {"views", score.views},
          {"shares",
           {{"seen", score.seen_percent / 100},
            {"remembered", score.remembered_percent / 100},
            {"extended", score.extended_percent / 100},
            {"empty", score.empty_percent / 100}}},
          {"psnr", score.psnr},
          {"psnr_seen", score.psnr_seen},
          {"psnr_remembered", finite(score.psnr_remembered)},
          {"psnr_extended", finite(score.psnr_extended)},
          {"psnr_silhouette", score.psnr_silhouette},
          {"psnr_moving", finite(score.psnr_moving)},
          {"psnr_alone", finite(result.psnr_alone)},
          {"psnr_together", finite(result.psnr_together)},
          {"recalled", score.recalled_percent / 100},
          {"flicker", score.flicker},
          {"flicker_remembered", score.flicker_remembered},
          {"flicker_extended", score.flicker_extended},
          {"seam_step", finite(score.seam_step)},
          {"sharpness", score.sharpness}};
}

int run(int argc, char** argv) {
  CLI::App app(kDescription, "view_bench");
  std::vector<std::string> scenes;
  for (const std::string_view name : scene_names()) scenes.emplace_back(name);
  const std::vector<std::string> all = scenes;
  RunSettings settings;
  std::string json, unseen = "extend";
  using namespace command_line;
  app.set_version_flag("--version", std::string("view_bench ") + kVersion);
  app.add_option("SCENE", scenes, "scenes to run: empty, standing, walking, four, own, waving [all]")
      ->check(one_of(all));
  app.add_option("--frames", settings.frames, "views to compare, at 30 per second, or 60 in waving")
      ->capture_default_str()
      ->check(whole_number(2, 3600));
  app.add_option("--unseen", unseen, "extend or black: as in render_client")
      ->capture_default_str()
      ->check(one_of({"extend", "black"}));
  app.add_option("--json", json, "file for the results as JSON")->check(writable_file());
  app.add_option("--pictures", settings.pictures, "existing folder for the last view and its truth, as PNG")
      ->check(existing_folder());
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_parse_error(app, error);
  }
  if (unseen == "black") settings.unseen.show = renderer::UnseenStyle::Show::kBlack;
  std::printf("%-9s %6s %6s %6s %6s %6s %6s %6s %6s %6s %6s %6s %6s %8s %7s %5s %9s\n", "scene", "seen %",
              "rem. %", "ext. %", "empty%", "PSNR", "seen", "rem.", "ext.", "edges", "moving", "alone",
              "both", "recall %", "flicker", "seam", "sharpness");
  nlohmann::json rows = nlohmann::json::array();
  for (const std::string& scene : scenes) {
    const auto result = run_scene(scene, settings);
    if (!result) {
      std::fprintf(stderr, "view_bench: %s\n", result.error().what.c_str());
      return 1;
    }
    const ViewScore& score = result->score;
    std::printf(
        "%-9s %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %6.2f %8.2f %7.2f %5.2f "
        "%9.2f\n",
        scene.c_str(), score.seen_percent, score.remembered_percent, score.extended_percent,
        score.empty_percent, score.psnr, score.psnr_seen, score.psnr_remembered, score.psnr_extended,
        score.psnr_silhouette, score.psnr_moving, result->psnr_alone, result->psnr_together,
        score.recalled_percent, score.flicker, score.seam_step, score.sharpness);
    std::fflush(stdout);
    rows.push_back(to_json(scene, *result));
  }
  if (json.empty()) return 0;
  std::ofstream file(json);
  file << rows.dump(2) << '\n';
  if (file.flush()) return 0;
  std::fprintf(stderr, "view_bench: %s cannot be written\n", json.c_str());
  return 1;
}

}  // namespace
}  // namespace copresence::view_bench

int main(int argc, char** argv) {
  return copresence::view_bench::run(argc, argv);
}
