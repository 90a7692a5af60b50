#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/command_line/values.h"
#include "common/scene/write_scene.h"
#include "common/text/excerpt.h"
#include "tools/calibrate/capture.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/intrinsics/camera_info.h"
#include "tools/calibrate/intrinsics/intrinsics_fit.h"
#include "tools/calibrate/intrinsics/picture_folder.h"
#include "tools/calibrate/markers/depth_to_color.h"
#include "tools/calibrate/pictures.h"
#include "tools/calibrate/report.h"

namespace copresence::calibrate {
namespace {

struct IntrinsicsSettings {
  std::vector<NamedSource> sources;
  std::string images, camera_info, name, out, json, picture, scene, scene_out;
  std::string size = "9x6";
  double square_mm = 25, marker_mm = 18;
  Board board;
  std::size_t frames = 90;
  double pause_s = 0.5;
  bool depth_to_color = false;
  bool overwrite = false;
  bool of_color_camera = false;  ///< True if the camera_info file is for the colour camera.
};

// The result of the search in the pictures of one camera.
struct Pictures {
  std::string camera;
  int width = 0, height = 0;
  std::vector<BoardView> views;
  BoardPictures shown;
  bool keeps_shown = false;
  std::size_t searched = 0, different = 0;
  bool is_depths_own = true;  ///< True if colour is registered to depth, so both share intrinsics.
  std::string seen_instead;   ///< Result of describe_other_board() for the first pictures.
  int descriptions = 0;
};

// Number of pictures searched for foil markers. More pictures of a still scene add nothing.
constexpr std::size_t kMostPictures = 20;
constexpr int kMostDescriptions = 3;  // Each call takes a second for a large picture.

Result<std::optional<scene::Scene>> scene_of(const IntrinsicsSettings& settings) {
  if (settings.scene.empty()) return std::optional<scene::Scene>();
  auto scene = scene::load(settings.scene);
  if (!scene) return fail(scene.error());
  return std::optional(std::move(*scene));
}

// Looks for the board in one picture. Returns a message for the user.
std::string search_picture(const Board& board, const ColorImage& picture, const std::string& name,
                           Pictures& out) {
  out.width = picture.width();
  out.height = picture.height();
  ++out.searched;
  auto view = find_board(board, picture, name);
  if (!view) {
    if (out.views.empty() && out.seen_instead.empty() && out.descriptions < kMostDescriptions) {
      ++out.descriptions;
      const std::string instead = describe_other_board(board, picture);
      if (!instead.empty()) out.seen_instead = fmt::format("{}: {}", name, instead);
    }
    return "no board";
  }
  const BoardView* same = same_view(*view, out.views, out.width);
  const std::string as = same ? same->picture : "";
  out.different += same == nullptr ? 1 : 0;
  if (out.keeps_shown && same == nullptr) out.shown.add(*view, picture);
  out.views.push_back(std::move(*view));
  return same ? fmt::format("the same view as {}: move the board", as)
              : fmt::format("board found, view {}", out.different);
}

Result<Pictures> pictures_of_source(const IntrinsicsSettings& settings, const scene::Scene* scene) {
  const NamedSource& source = settings.sources[0];
  auto capture = Capture::open(source, scene, Capture::Frames::kAsDelivered);
  if (!capture) return fail(capture.error());
  const std::chrono::milliseconds pause(static_cast<int>(1000 * settings.pause_s));
  Pictures out;
  out.keeps_shown = !settings.picture.empty();
  out.camera = source.name;
  out.is_depths_own = capture->sensor().registered;
  const auto looked = for_each_frame(*capture, settings.frames, pause, [&](const RgbdFrame& frame) {
    if (!frame.color) return std::string("no colour");
    const auto number = source.is_stream ? out.searched + 1 : frame.metadata.sequence;
    return search_picture(settings.board, *frame.color,
                          fmt::format("{} {}", source.is_stream ? "picture" : "frame", number), out);
  });
  // Views collected before an error are kept, because a person held up the board for them.
  if (!looked && out.different < kFewestViews) return fail(looked.error());
  if (!looked || (source.is_stream && *looked < settings.frames)) {
    fmt::print(stderr, "{} ended{}; continuing with the {} pictures so far\n", source.from,
               looked ? "" : " (" + looked.error().what + ")", out.searched);
  }
  if (out.searched == 0) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{} has no colour pictures to look for a board in", source.from));
  }
  return out;
}

Result<Pictures> pictures_of_folder(const IntrinsicsSettings& settings) {
  const auto folder = open_picture_folder(settings.images);
  if (!folder) return fail(folder.error());
  if (!folder->remark.empty()) fmt::print(stderr, "{}\n", folder->remark);
  Pictures out;
  out.keeps_shown = !settings.picture.empty();
  out.camera = settings.name.empty() ? "camera" : settings.name;
  for (const auto& file : folder->files) {
    const auto picture = load_picture(*folder, file);
    if (!picture) return fail(picture.error());
    const std::string name = file.filename().string();
    const std::string found = search_picture(settings.board, *picture, name, out);
    fmt::print(stderr, "picture {} of {}, {}: {}\n", out.searched, folder->files.size(), name, found);
  }
  return out;
}

constexpr double kMostUnequalFocals = 0.02, kLeastCovered = 0.6;

void print_fit(const IntrinsicsFit& fit, const Pictures& pictures) {
  const CameraModel& m = fit.model;
  fmt::print("{} pictures, board found in {}, {} used\n", pictures.searched, pictures.views.size(),
             fit.views.size());
  for (const ViewFit& view : fit.views) fmt::print("{:<24}{:.3f} px\n", view.picture, view.rms_px);
  for (const DroppedView& view : fit.dropped) fmt::print("{:<24}left out: {}\n", view.picture, view.why);
  fmt::print(
      "fx {:.2f} fy {:.2f} (+- {:.2f}) cx {:.2f} cy {:.2f} (+- {:.2f}) pixels, distortion {}, reprojection "
      "error "
      "{:.3f} px, {:.0f} % of the picture covered\n",
      m.fx, m.fy, fit.focal_sigma_px, m.cx, m.cy, fit.center_sigma_px, fit.distortion, fit.rms_px,
      100 * fit.covered);
  if (times_good_rms(fit) > 1) {
    fmt::print(
        "the error is larger than that of a good calibration ({:.1f} px): is the board flat and as wide and "
        "high as "
        "given, were the pictures sharp, and are they all of one camera without zoom?\n",
        fit.rms_px / times_good_rms(fit));
  }
  if (std::abs(m.fx / m.fy - 1) > kMostUnequalFocals) {
    fmt::print("fx and fy differ by {:.1f} %: are the board's squares as wide as high? Measure its print\n",
               100 * std::abs(m.fx / m.fy - 1));
  }
  if (fit.covered < kLeastCovered) {
    fmt::print(
        "few corners are near the picture's edges, so the distortion is uncertain there: show the board in "
        "the "
        "picture's corners too\n");
  }
}

// Changes a camera of the scene file and writes the file. For a new camera, `change` must set
// everything that a scene file needs.
template <class Change>
Result<void> change_camera(const IntrinsicsSettings& settings, std::optional<scene::Scene> scene,
                           const std::string& name, Change&& change) {
  if (settings.scene_out.empty()) return {};
  if (!scene) scene.emplace();
  auto found = std::find_if(scene->cameras.begin(), scene->cameras.end(),
                            [&](const scene::Camera& camera) { return camera.name == name; });
  if (found == scene->cameras.end()) {
    found = scene->cameras.insert(found, scene::Camera{});
    found->name = name;
  }
  change(*found);
  if (const auto usable = check(found->model); !usable) {
    return fail(ErrorCode::kInvalid, fmt::format("the scene file must have the depth intrinsics of camera "
                                                 "\"{}\" before it can have a colour camera: "
                                                 "give --scene",
                                                 name));
  }
  remember_key(settings.sources, *scene);
  return scene::save(*scene, settings.scene_out, settings.scene);
}

Result<void> fit_to_board(const IntrinsicsSettings& settings) {
  const auto scene = scene_of(settings);
  if (!scene) return fail(scene.error());
  auto pictures = settings.images.empty() ? pictures_of_source(settings, *scene ? &**scene : nullptr)
                                          : pictures_of_folder(settings);
  if (!pictures) return fail(pictures.error());
  if (pictures->views.empty()) {
    const std::string kind = settings.board.kind == Board::Kind::kChessboard ? "inner corners" : "squares";
    return fail(ErrorCode::kNotFound,
                fmt::format("none of {} pictures shows the whole board ({}x{} {}){}", pictures->searched,
                            settings.board.columns, settings.board.rows, kind,
                            pictures->seen_instead.empty() ? ": is its size as given?"
                                                           : "; " + pictures->seen_instead));
  }
  const auto legacy =
      std::count_if(pictures->views.begin(), pictures->views.end(),
                    [](const BoardView& view) { return view.layout == CharucoLayout::kMarkerCorner; });
  if (legacy > 0) {
    fmt::print(
        stderr,
        "the board has a marker in its top left square, like boards of OpenCV before 4.6 with an even number "
        "of rows; it is used as such ({} pictures)\n",
        legacy);
  }
  std::vector<DroppedView> dropped;
  const auto views = select_views(pictures->views, pictures->width, dropped);
  auto fit = fit_intrinsics(views, pictures->width, pictures->height);
  if (!fit) {
    return fail(fit.error().code, fmt::format("{} pictures, board found in {}: {}", pictures->searched,
                                              pictures->views.size(), fit.error().what));
  }
  fit->dropped.insert(fit->dropped.begin(), dropped.begin(), dropped.end());
  print_fit(*fit, *pictures);
  if (!settings.json.empty()) {
    if (auto written = write_json(to_json(*fit, pictures->camera), settings.json); !written) return written;
  }
  if (!settings.picture.empty()) {
    if (auto shown = pictures->shown.write(*fit, settings.picture); !shown) return shown;
  }
  if (!settings.out.empty()) {
    if (auto saved = save_camera_info({pictures->camera, fit->model}, settings.out); !saved) return saved;
  }
  return change_camera(settings, *scene, pictures->camera, [&](scene::Camera& camera) {
    if (!pictures->is_depths_own) {
      if (!camera.color) camera.color.emplace();
      camera.color->model = fit->model;
    } else {
      camera.model = fit->model;
    }
  });
}

// Copies intrinsics from a camera_info file.
Result<void> import_intrinsics(const IntrinsicsSettings& settings) {
  if (settings.out.empty() && settings.scene_out.empty()) {
    return fail(ErrorCode::kInvalid,
                "--camera-info puts intrinsics into a scene file: give --scene-out as well");
  }
  const auto scene = scene_of(settings);
  if (!scene) return fail(scene.error());
  auto info = load_camera_info(settings.camera_info);
  if (!info) return fail(info.error());
  if (!settings.name.empty()) info->name = settings.name;
  if (info->name.empty()) {
    return fail(ErrorCode::kInvalid,
                settings.camera_info + ": has no camera_name; name the camera with --name");
  }
  if (!text::is_printable(info->name)) {
    return fail(ErrorCode::kInvalid,
                fmt::format("the camera's name \"{}\" is not UTF-8 text: save {} as UTF-8, or give --name",
                            text::sanitise(info->name, 64), settings.camera_info));
  }
  if (!info->remark.empty()) fmt::print(stderr, "{}: {}\n", settings.camera_info, info->remark);
  const CameraModel& m = info->model;
  fmt::print("{}: {}x{} pixels, fx {:.2f} fy {:.2f} cx {:.2f} cy {:.2f}\n", info->name, m.width, m.height,
             m.fx, m.fy, m.cx, m.cy);
  if (!settings.out.empty()) {
    if (auto saved = save_camera_info(*info, settings.out); !saved) return saved;
  }
  return change_camera(settings, *scene, info->name, [&](scene::Camera& camera) {
    if (!settings.of_color_camera) {
      camera.model = info->model;
      return;
    }
    if (!camera.color) camera.color.emplace();
    camera.color->model = info->model;
  });
}

Result<void> calibrate_depth_to_color(const IntrinsicsSettings& settings) {
  const auto scene = scene_of(settings);
  if (!scene) return fail(scene.error());
  const NamedSource& source = settings.sources[0];
  auto capture = Capture::open(source, *scene ? &**scene : nullptr, Capture::Frames::kAsDelivered);
  if (!capture) return fail(capture.error());
  const sensor::SensorDescription& sensor = capture->sensor();
  if (sensor.registered) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{} says that its sensor registers colour to depth itself, so there is nothing to find; "
                    "if it does not, put the intrinsics of its colour camera into the scene file first "
                    "(--camera-info FILE --color-camera)",
                    source.from));
  }
  auto finder = DepthToColorFinder::open(sensor.unit, settings.board.dictionary, settings.board.border_bits);
  if (!finder) return fail(finder.error());
  const std::size_t all = frames_to_read(*capture, settings.frames);
  std::size_t number = 0;
  const auto looked = for_each_frame(*capture, settings.frames, {}, [&](const RgbdFrame& frame) {
    finder->add_depth(frame.depth);
    if (frame.color && is_sampled(kMostPictures, number, all)) finder->add_color(*frame.color);
    ++number;
    return std::string();
  });
  if (!looked) return fail(looked.error());
  const auto fit = finder->fit(sensor.depth, sensor.color);
  if (!fit) return fail(fit.error());
  const Eigen::Vector3d t = 1000 * fit->color_from_depth.translation;
  fmt::print(
      "{} markers, error {:.2f} px, worst {:.2f} px; the colour camera is {:.1f} {:.1f} {:.1f} mm from the "
      "depth camera, expected shift {:.1f} mm\n",
      fit->markers, fit->rms_px, fit->worst_px, -t.x(), -t.y(), -t.z(), 1000 * fit->expected_shift_m);
  return change_camera(settings, *scene, source.name, [&](scene::Camera& camera) {
    camera.model = sensor.depth;
    camera.color = scene::ColorCamera{sensor.color, fit->color_from_depth};
  });
}

}  // namespace

Command intrinsics_command(CLI::App& program) {
  auto settings = std::make_shared<IntrinsicsSettings>();
  CLI::App* parser = program.add_subcommand(
      "intrinsics",
      "Finds a camera's intrinsics (focal lengths, principal point, k1 to k6, p1, p2) from pictures of a "
      "chessboard or ChArUco board. With --depth-to-color it finds the pose of a sensor's colour camera "
      "relative to its depth camera.");
  const SourceOptions source = add_source_options(*parser, settings->sources, 0, 1);
  auto* images =
      parser->add_option("--images", settings->images, "folder of pictures (PNG, JPEG) of one camera")
          ->check(command_line::existing_folder())
          ->excludes(source.recording)
          ->excludes(source.stream);
  auto* camera_info = parser
                          ->add_option("--camera-info", settings->camera_info,
                                       "read the intrinsics from a ROS camera_info YAML file instead")
                          ->check(command_line::existing_file())
                          ->excludes(images)
                          ->excludes(source.recording)
                          ->excludes(source.stream);
  parser
      ->add_flag("--color-camera", settings->of_color_camera,
                 "with --camera-info: the file is for the colour camera of a sensor that does not register")
      ->needs(camera_info);
  parser
      ->add_option("--name", settings->name,
                   "the camera's name, with --images or --camera-info [camera; the file's own]")
      ->check(command_line::some("a name"))
      ->excludes(source.recording)
      ->excludes(source.stream);
  parser->add_option("--board", settings->board.kind, "chessboard or charuco [chessboard]")
      ->transform(command_line::one_of<Board::Kind>(
          {{"chessboard", Board::Kind::kChessboard}, {"charuco", Board::Kind::kCharuco}}));
  parser
      ->add_option("--board-size", settings->size,
                   "COLUMNSxROWS: inner corners of a chessboard, squares of a ChArUco board")
      ->check([settings](const std::string& text) { return parse_board_size(text, settings->board); })
      ->capture_default_str();
  parser->add_option("--square", settings->square_mm, "side of a square, mm")
      ->check(command_line::number(1, 1000))
      ->capture_default_str();
  parser->add_option("--marker", settings->marker_mm, "side of a ChArUco board's markers, mm")
      ->check(command_line::number(1, 1000))
      ->capture_default_str();
  add_dictionary(*parser, settings->board.dictionary, settings->board.border_bits,
                 "dictionary of the ChArUco board's markers");
  parser
      ->add_option("--frames", settings->frames, "number of frames to search, evenly spread over a recording")
      ->check(command_line::whole_number(1, 10000))
      ->capture_default_str();
  parser
      ->add_option("--pause", settings->pause_s,
                   "with --stream: seconds between the searched frames, for moving the board")
      ->check(command_line::number(0, 60))
      ->capture_default_str();
  auto* to_color =
      parser->add_flag("--depth-to-color", settings->depth_to_color,
                       "find the rigid transform from depth to colour by markers whose dark cells return no "
                       "depth; the scene file or the recording must have both intrinsics");
  to_color->excludes(images)->excludes(camera_info)->needs(source.recording);
  parser->add_option("--out", settings->out, "write the intrinsics as ROS camera_info YAML")
      ->check(command_line::writable_file())
      ->excludes(to_color);
  parser->add_option("--json", settings->json, "also write the report as JSON")
      ->check(command_line::writable_file())
      ->excludes(to_color);
  parser
      ->add_option("--picture", settings->picture,
                   "write the pictures with the corners that were found and their errors (.png or .jpg)")
      ->check(picture_file_name())
      ->excludes(to_color);
  parser->add_option("--scene", settings->scene, "scene file to start from")
      ->check(command_line::existing_file());
  parser
      ->add_option("--scene-out", settings->scene_out,
                   "write the intrinsics into a scene file; may be the file of --scene")
      ->check(command_line::replaceable_file());
  add_overwrite(*parser, settings->overwrite);
  return {parser, [settings]() -> Result<void> {
            settings->board.square_m = settings->square_mm * 1e-3;
            settings->board.marker_m = settings->marker_mm * 1e-3;
            const auto kept =
                refuse_existing({settings->out, settings->json, settings->picture}, settings->overwrite);
            if (!kept) return kept;
            if (auto other = refuse_other_than_scene(settings->scene_out, settings->overwrite); !other)
              return other;
            if (!settings->camera_info.empty()) return import_intrinsics(*settings);
            if (settings->sources.empty() && settings->images.empty()) {
              return fail(ErrorCode::kInvalid,
                          "give --recording NAME=FILE.oni, --stream NAME=HOST:PORT, --images FOLDER or "
                          "--camera-info FILE");
            }
            if (const std::string problem = problem_of(settings->board); !problem.empty()) {
              return fail(ErrorCode::kInvalid, problem);
            }
            return settings->depth_to_color ? calibrate_depth_to_color(*settings) : fit_to_board(*settings);
          }};
}

}  // namespace copresence::calibrate
