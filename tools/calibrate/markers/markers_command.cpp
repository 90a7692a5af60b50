#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>

#include "common/command_line/values.h"
#include "common/scene/write_scene.h"
#include "tools/calibrate/capture.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/geometry/marker_layout.h"
#include "tools/calibrate/intrinsics/still_board.h"
#include "tools/calibrate/markers/clicks.h"
#include "tools/calibrate/markers/dictionary.h"
#include "tools/calibrate/markers/marker_finder.h"
#include "tools/calibrate/pictures.h"
#include "tools/calibrate/report.h"

namespace copresence::calibrate {
namespace {

struct MarkerSettings {
  std::vector<NamedSource> sources;
  std::string scene, out, json, reference, dictionary = "4x4_50", points, save_points;
  std::string picture, chessboard;  ///< `chessboard` is COLUMNSxROWS, or empty for markers.
  Board board;
  double square_mm = 25;
  int border_bits = 1;
  bool click = false, overwrite = false;
  std::size_t frames = 60;
  Solver solver = Solver::kRigid;
};

struct SourceMarkers {
  scene::Camera camera;
  std::vector<FoundMarker> markers;
  DepthAverage depth{DepthUnit::kMillimetre};
  std::vector<Unused> unused;
  ColorImage picture;
  std::optional<StillBoard> board;
};

// Errors of intrinsics and depth cannot explain a larger relative error of a board's size.
constexpr double kWrongSize = 0.15;
constexpr std::size_t kMostPictures = 20;  // More pictures of a still scene add nothing.

Result<SourceMarkers> read_source(const NamedSource& source, const scene::Scene* scene,
                                  const MarkerSettings& settings, Clicks& clicks) {
  const scene::Camera* known = scene ? scene->find(source.name) : nullptr;
  auto capture = Capture::open(source, scene);
  if (!capture) return fail(capture.error());

  SourceMarkers result;
  if (known) result.camera = *known;
  result.camera.name = source.name;
  result.camera.model = capture->model();
  result.camera.world_from_camera = capture->world_from_camera();
  std::string& origin = source.is_stream ? result.camera.address : result.camera.source;
  if (origin.empty()) origin = source.from;
  result.depth = DepthAverage(capture->unit());
  auto finder = MarkerFinder::open(settings.dictionary, settings.border_bits);
  if (!finder) return fail(finder.error());
  std::vector<ColorImage> of_board;
  const std::size_t all = frames_to_read(*capture, settings.frames);
  std::size_t number = 0;
  const auto done = for_each_frame(*capture, settings.frames, {}, [&](const RgbdFrame& frame) {
    result.depth.add(frame.depth);
    const bool is_searched = is_sampled(kMostPictures, number++, all);
    if (!frame.color) return std::string();
    if (result.picture.pixels().empty()) result.picture = *frame.color;
    if (!is_searched) return std::string();
    if (settings.chessboard.empty()) {
      finder->add(*frame.color);
    } else {
      of_board.push_back(*frame.color);
    }
    return std::string();
  });
  if (!done) return fail(done.error());
  if (result.picture.pixels().empty()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{} has no colour pictures to look for markers in", source.from));
  }
  if (!settings.chessboard.empty()) {
    auto board = find_still_board(settings.board, of_board, result.camera.model);
    if (!board) return fail(board.error().code, fmt::format("{}: {}", source.from, board.error().what));
    const auto ratio = size_over_depth(*board, settings.board, result.depth, result.camera.model);
    if (ratio && std::abs(*ratio - 1) > kWrongSize) {
      const double away = board->pose.camera_from_board.translation.z();
      return fail(
          ErrorCode::kInvalid,
          fmt::format("{}: with squares of {:g} mm the board is {:.2f} m away, but depth measures {:.2f} m "
                      "there, as of squares of {:.0f} mm: measure them and give --square",
                      source.from, settings.square_mm, away, away / *ratio, settings.square_mm / *ratio));
    }
    result.board = std::move(*board);
    return result;
  }
  result.markers = finder->found(result.camera.model);
  for (const std::string& name : finder->moved()) {
    result.unused.push_back({source.name, name, "it moved while it was recorded"});
  }
  if (settings.click) {
    auto clicked = ask_for_clicks(source.name, result.picture);
    if (!clicked) return fail(clicked.error());
    clicks[source.name] = std::move(*clicked);
  }
  for (const FoundMarker& clicked : clicks[source.name]) {  // A click replaces a marker that was found.
    std::erase_if(result.markers, [&](const FoundMarker& marker) { return marker.name == clicked.name; });
    result.markers.push_back(clicked);
  }
  if (result.markers.size() < kFewestMarkers && clicks[source.name].empty()) {
    const auto other = find_dictionary(result.picture);
    if (other && other->markers > static_cast<int>(result.markers.size()) &&
        (other->name != settings.dictionary || other->border_bits != settings.border_bits)) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{} shows {} markers of {}, but {}", source.from, result.markers.size(),
                              settings.dictionary, other->in_words()));
    }
  }
  return result;
}

std::vector<std::string> marker_names(const std::vector<SourceMarkers>& cameras) {
  const auto by_number = [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  };
  std::set<std::string, decltype(by_number)> names(by_number);
  for (const SourceMarkers& camera : cameras) {
    for (const FoundMarker& marker : camera.markers) names.insert(marker.name);
    if (!camera.board) continue;
    for (std::size_t i = 0; i < camera.board->view.pixels.size(); ++i) names.insert(std::to_string(i + 1));
  }
  return {names.begin(), names.end()};
}

Result<std::size_t> reference_of(const MarkerSettings& settings) {
  for (std::size_t c = 0; c < settings.sources.size(); ++c) {
    if (settings.reference.empty() || settings.sources[c].name == settings.reference) return c;
  }
  return fail(
      ErrorCode::kInvalid,
      fmt::format("--reference names \"{}\", but no --recording or --stream does", settings.reference));
}

// No sensor has a larger error, so the input must be wrong.
constexpr double kUnbelievable_m = 0.1;

Result<void> check_plausible(const MarkerReport& report) {
  const auto worst = std::max_element(
      report.fit.cameras.begin(), report.fit.cameras.end(),
      [](const CameraFit& a, const CameraFit& b) { return a.residual.worst < b.residual.worst; });
  if (worst == report.fit.cameras.end() || worst->residual.worst < kUnbelievable_m) return {};
  return fail(
      ErrorCode::kRefused,
      fmt::format("{} sees marker {} {:.0f} mm away from where all cameras together put it, so no scene "
                  "file is written: cover that marker, or click it again if it was clicked (the same "
                  "markers in the same order in every camera); if most are as bad, the intrinsics are wrong "
                  "or a camera was moved",
                  report.names.cameras[static_cast<std::size_t>(worst - report.fit.cameras.begin())],
                  report.names.markers[worst->residual.worst_at], 1000 * worst->residual.worst));
}

Result<void> write_results(const MarkerSettings& settings, scene::Scene scene,
                           const std::vector<SourceMarkers>& cameras, const MarkerReport& report) {
  if (!settings.json.empty()) {
    if (auto written = write_json(to_json(report), settings.json); !written) return written;
  }
  if (const auto believable = check_plausible(report); !believable) return believable;
  if (settings.out.empty()) return {};
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    scene::Camera camera = cameras[c].camera;
    camera.world_from_camera = report.fit.cameras[c].world_from_camera;
    camera.calibration_error_mm = std::round(1e4 * report.fit.cameras[c].expected_shift_m) / 10;
    const auto known = std::find_if(scene.cameras.begin(), scene.cameras.end(),
                                    [&](const scene::Camera& other) { return other.name == camera.name; });
    if (known == scene.cameras.end()) {
      scene.cameras.push_back(std::move(camera));
    } else {
      *known = std::move(camera);
    }
  }
  remember_key(settings.sources, scene);
  return scene::save(scene, settings.out, settings.scene);
}

Result<void> calibrate_by_markers(const MarkerSettings& settings) {
  const auto reference = reference_of(settings);
  if (!reference) return fail(reference.error());
  std::optional<scene::Scene> scene;
  if (!settings.scene.empty()) {
    auto loaded = scene::load(settings.scene);
    if (!loaded) return fail(loaded.error());
    scene = std::move(*loaded);
  }
  Clicks clicks;
  if (!settings.points.empty()) {
    auto loaded = load_clicks(settings.points);
    if (!loaded) return fail(loaded.error());
    for (const auto& [camera, points] : *loaded) {
      if (std::none_of(settings.sources.begin(), settings.sources.end(),
                       [&](const NamedSource& source) { return source.name == camera; })) {
        return fail(
            ErrorCode::kInvalid,
            fmt::format("{} has points of camera \"{}\", but no --recording or --stream has that name",
                        settings.points, camera));
      }
    }
    clicks = std::move(*loaded);
  }

  if (const auto there = check_sources(settings.sources, scene ? &*scene : nullptr); !there) return there;
  std::vector<SourceMarkers> cameras;
  MarkerReport report;
  for (const NamedSource& source : settings.sources) {
    auto result = read_source(source, scene ? &*scene : nullptr, settings, clicks);
    if (!result) return fail(result.error());
    if (result->board) {
      fmt::print(stderr, "{}: board at {:.2f} m, error {:.2f} px\n", source.name,
                 result->board->pose.camera_from_board.translation.z(), result->board->pose.rms_px);
    } else {
      fmt::print(stderr, "{}: {} markers\n", source.name, result->markers.size());
    }
    report.names.cameras.push_back(source.name);
    report.unused.insert(report.unused.end(), result->unused.begin(), result->unused.end());
    cameras.push_back(std::move(*result));
  }
  if (!settings.save_points.empty()) {
    if (auto saved = save_clicks(clicks, settings.save_points); !saved) return saved;
  }

  report.names.markers = marker_names(cameras);
  report.reference = *reference;
  report.of_board = !settings.chessboard.empty();
  report.solver = settings.solver;
  std::vector<Observation> observations;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (cameras[c].board) {
      for (Observation& observation : observations_of(c, *cameras[c].board, cameras[c].camera.model)) {
        observations.push_back(observation);
      }
      report.depths.emplace_back();
      continue;
    }
    CameraObservations seen = observations_of(c, report.names.cameras[c], cameras[c].camera.model,
                                              cameras[c].markers, cameras[c].depth, report.names.markers);
    observations.insert(observations.end(), seen.observations.begin(), seen.observations.end());
    report.unused.insert(report.unused.end(), seen.unused.begin(), seen.unused.end());
    report.depths.push_back(std::move(seen.depths));
  }
  const WorldSettings world{*reference, cameras[*reference].camera.world_from_camera.value_or(Rigid3{}),
                            settings.solver, !settings.chessboard.empty()};
  auto fit = fit_world(observations, report.names, world);
  if (!fit) {
    std::string why = fit.error().what;
    for (const Unused& unused : report.unused) {
      why += fmt::format("; marker {} in {} could not be used: {}", unused.marker, unused.camera, unused.why);
    }
    return fail(fit.error().code, why);
  }
  report.fit = std::move(*fit);
  fmt::print("{}", to_text(report));
  if (!settings.picture.empty()) {
    std::vector<MarkedPicture> pictures;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      pictures.push_back({report.names.cameras[c], cameras[c].picture, cameras[c].markers, report.depths[c]});
    }
    const auto written =
        write_marked_pictures(pictures, report.names, observations, report.fit, settings.picture);
    if (!written) return written;
  }
  return write_results(settings, scene.value_or(scene::Scene{}), cameras, report);
}

}  // namespace

Command markers_command(CLI::App& program) {
  auto settings = std::make_shared<MarkerSettings>();
  CLI::App* parser = program.add_subcommand(
      "markers",
      "Finds the poses of cameras from markers that do not move. Each pair of "
      "neighbouring cameras must see at least four in common. Prints errors in millimetres.");
  add_source_options(*parser, settings->sources, 2, 64);
  parser
      ->add_option("--scene", settings->scene,
                   "scene file to start from: its intrinsics, cameras and comments stay")
      ->check(command_line::existing_file());
  parser
      ->add_option("--out", settings->out,
                   "scene file to write; may be the file of --scene, whose comments stay")
      ->check(command_line::replaceable_file());
  parser->add_option("--json", settings->json, "also write the report as JSON")
      ->check(command_line::writable_file());
  parser
      ->add_option(
          "--picture", settings->picture,
          "write the pictures of all cameras with the markers, their distances and errors (.png or .jpg)")
      ->check(picture_file_name());
  parser
      ->add_option("--reference", settings->reference,
                   "camera whose pose does not change; without a pose in the scene file or recording it is "
                   "the world's "
                   "origin [first]")
      ->check(command_line::some("a camera's name"));
  parser
      ->add_option("--solver", settings->solver,
                   "rigid: rotations and translations of all cameras together; linear: the thesis's 12 "
                   "unknowns for each "
                   "pair [rigid]")
      ->transform(command_line::one_of<Solver>({{"rigid", Solver::kRigid}, {"linear", Solver::kLinear}}));
  add_dictionary(*parser, settings->dictionary, settings->border_bits,
                 "dictionary of the ArUco or AprilTag markers");
  parser
      ->add_option("--frames", settings->frames,
                   "number of frames of each camera over which depth is averaged")
      ->check(command_line::whole_number(1, 10000))
      ->capture_default_str();
  parser->add_flag("--click", settings->click,
                   "click the markers in a window for each camera, in the same order");
  parser
      ->add_option("--points", settings->points,
                   "read clicks from a file with lines \"camera marker x y\", pixels")
      ->check(command_line::existing_file());
  parser->add_option("--save-points", settings->save_points, "write the clicks to such a file")
      ->check(command_line::writable_file());
  parser
      ->add_option(
          "--chessboard", settings->chessboard,
          "use a chessboard of COLUMNSxROWS inner corners instead of markers; it must stand still and "
          "upright where all cameras see it; depth only checks --square")
      ->check([settings](const std::string& text) { return parse_board_size(text, settings->board); });
  parser->add_option("--square", settings->square_mm, "side of the chessboard's squares, mm")
      ->check(command_line::number(1, 1000))
      ->capture_default_str();
  add_overwrite(*parser, settings->overwrite);
  return {parser, [settings]() -> Result<void> {
            settings->board.square_m = settings->square_mm * 1e-3;
            const auto kept = refuse_existing({settings->json, settings->picture, settings->save_points},
                                              settings->overwrite);
            if (!kept) return kept;
            if (auto other = refuse_other_than_scene(settings->out, settings->overwrite); !other)
              return other;
            return calibrate_by_markers(*settings);
          }};
}

}  // namespace copresence::calibrate
