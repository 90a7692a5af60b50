#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <numbers>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_writer.h"
#include "render_client/viewpoint/eye_path.h"
#include "render_client/viewpoint/look_at.h"
#include "simulation/sensor/simulated_kinect.h"
#include "tools/simulate_kinect/output.h"
#include "tools/simulate_kinect/settings.h"

namespace copresence::simulate_kinect {
namespace {

const Eigen::Vector3d kUp{0, -1, 0};  // In all simulated worlds, y points down.

Result<std::filesystem::path> make_folder(const std::filesystem::path& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: the folder cannot be created: {}", folder.string(), problem.message()));
  }
  return folder;
}

// The time of a frame at 30 frames per second. Rounding errors do not accumulate.
std::chrono::microseconds time_of(int frame) {
  return std::chrono::microseconds((static_cast<std::int64_t>(frame) * 1'000'000 + 15) / 30);
}

// An artificial start time from 2000 to 2010, computed from the arguments. The same command gives
// the same bytes, all cameras of a session start together, and sessions differ in their start.
std::chrono::microseconds invented_start(const Settings& settings) {
  constexpr std::uint32_t kSecondsOfTenYears = 10 * 365 * 24 * 3600;
  constexpr std::chrono::seconds kYear2000{946'684'800};
  std::uint32_t hash = 2'166'136'261;
  for (const char c : fmt::format("{} {} {} {} {}x{}", settings.world, settings.cameras, settings.frames,
                                  settings.seed, settings.width, settings.height)) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 16'777'619;
  }
  return kYear2000 + std::chrono::seconds(hash % kSecondsOfTenYears);
}

Result<void> record(const Settings& settings, const std::shared_ptr<const simulation::LitScene>& world,
                    const std::vector<Rigid3>& poses, std::size_t index) {
  const CameraModel model = simulation::kinect_model(settings.width, settings.height);
  auto kinect = simulation::SimulatedKinect::make(world, model, poses, index, settings.unit, settings.seed);
  if (!kinect) return fail(kinect.error());
  const std::string name = fmt::format("camera{}", index);
  recording::OniContent content;
  content.camera = {name, model, true, settings.unit, poses[index]};
  content.jpeg_quality = settings.jpeg_quality;
  content.unix_zero_us = invented_start(settings).count();
  auto writer =
      recording::OniWriter::create((settings.folder / (name + ".oni")).string(), content,
                                   settings.overwrite ? file::Existing::kReplace : file::Existing::kKeep);
  if (!writer) return fail(writer.error());
  std::filesystem::path truth;
  if (settings.truth) {
    const auto folder = make_folder(settings.folder / "truth" / name);
    if (!folder) return fail(folder.error());
    truth = *folder;
  }

  DepthImage depth;
  ColorImage color;
  for (int frame = 0; frame < settings.frames; ++frame) {
    const auto number = static_cast<std::uint64_t>(frame);
    kinect->capture(simulation::phase_of_frame(number, static_cast<std::uint64_t>(settings.frames)), number,
                    depth, color);
    if (auto written = writer->write_depth(time_of(frame), depth); !written) return written;
    if (auto written = writer->write_color(time_of(frame), color); !written) return written;
    if (settings.truth) {
      if (auto written = write_truth(truth, frame, kinect->truth()); !written) return written;
    }
  }
  if (auto finished = writer->finish(); !finished) return finished;
  return recording::check_written(writer->path());
}

Result<void> show_truth(const Settings& settings, const std::shared_ptr<const simulation::LitScene>& world,
                        const std::filesystem::path& path_file) {
  const auto path = viewpoint::EyePath::load(path_file);
  if (!path) return fail(path.error());
  const auto folder = make_folder(settings.folder / "truth" / path_file.stem());
  if (!folder) return fail(folder.error());
  const CameraModel model = camera_from_field_of_view(settings.truth_width, settings.truth_height,
                                                      settings.truth_fov_deg * std::numbers::pi / 180);
  for (int frame = 0; frame < settings.frames; ++frame) {
    const auto place = path->at(static_cast<std::uint64_t>(frame));
    auto camera = simulation::TrueCamera::make(world, model, viewpoint::look_at(place.eye, place.look, kUp));
    if (!camera) return fail(camera.error());
    const double phase = simulation::phase_of_frame(static_cast<std::uint64_t>(frame),
                                                    static_cast<std::uint64_t>(settings.frames));
    if (auto written = write_truth(*folder, frame, camera->trace(phase)); !written) return written;
  }
  return {};
}

// Fails before anything is rendered if an output file already exists.
Result<void> keep_existing(const Settings& settings) {
  std::vector<std::filesystem::path> files{settings.folder / "scene.toml"};
  for (int i = 0; i < settings.cameras; ++i)
    files.push_back(settings.folder / fmt::format("camera{}.oni", i));
  for (const auto& file : files) {
    std::error_code ignored;
    if (std::filesystem::exists(std::filesystem::symlink_status(file, ignored))) {
      return fail(
          ErrorCode::kInvalid,
          fmt::format("{}: exists already and is kept; give another folder or --overwrite", file.string()));
    }
  }
  return {};
}

Result<void> simulate(const Settings& settings) {
  if (auto folder = make_folder(settings.folder); !folder) return fail(folder.error());
  if (!settings.overwrite) {
    if (auto free = keep_existing(settings); !free) return free;
  }
  auto made = simulation::LitScene::of_world(settings.world);
  if (!made) return fail(made.error());
  const auto world = std::make_shared<const simulation::LitScene>(std::move(*made));
  const std::vector<Rigid3> poses = simulation::kinect_poses(settings.cameras);
  for (std::size_t index = 0; index < poses.size(); ++index) {
    if (auto recorded = record(settings, world, poses, index); !recorded) return recorded;
    fmt::print(stderr, "camera{}.oni: {} frames\n", index, settings.frames);
  }
  for (const auto& path_file : settings.truth_views) {
    if (auto shown = show_truth(settings, world, path_file); !shown) return shown;
  }
  const std::string made_by =
      fmt::format("simulate_kinect {} --cameras {} --frames {} --seed {} --size {}x{}", settings.world,
                  settings.cameras, settings.frames, settings.seed, settings.width, settings.height);
  return write_text(settings.folder / "scene.toml",
                    scene_toml(simulation::kinect_model(settings.width, settings.height), poses, made_by));
}

}  // namespace
}  // namespace copresence::simulate_kinect

int main(int argc, char** argv) {
  const auto settings = copresence::simulate_kinect::read_command_line(argc, argv);
  if (!settings) return settings.error();
  if (const auto done = copresence::simulate_kinect::simulate(*settings); !done) {
    fmt::print(stderr, "simulate_kinect: {}\n", done.error().what);
    return 1;
  }
  return 0;
}
