#include "tools/view_bench/room_views.h"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/temporal_filter/color_filter.h"
#include "capture_server/temporal_filter/depth_filter.h"
#include "common/color/yuv420.h"
#include "common/flow/worker_pool.h"
#include "render_client/background_memory/background_memory.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/color_matching/color_matcher.h"
#include "render_client/decoding/frame_conditioning.h"
#include "render_client/display/screenshot.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/viewpoint/look_at.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::view_bench {
namespace {

constexpr int kCameraWidth = 640, kCameraHeight = 480;
constexpr int kSettlingFrames = 30;
constexpr std::uint32_t kSeed = 7;
constexpr double kCalibrationErrorM = 0.005;
const DepthRange kRange;

struct SceneChoice {
  std::string_view name;
  int cameras;
  bool person, walks;
};

constexpr std::array kScenes{
    SceneChoice{"empty", 2, false, false}, SceneChoice{"standing", 2, true, false},
    SceneChoice{"walking", 2, true, true}, SceneChoice{"four", 4, true, false},
    SceneChoice{"own", 1, true, false},
};

// The person walks on the spot, and is carried 2 m through the middle of the room and back.
std::vector<Eigen::Isometry3f> walk(double phase) {
  static const auto stand = simulation::make_scene("room")->figure.motion;
  constexpr float kHalfWayM = 1.0F;
  const auto x = static_cast<float>(kHalfWayM * std::sin(2 * std::numbers::pi * phase));
  auto parts = stand(phase);
  for (Eigen::Isometry3f& part : parts) part.pretranslate(Eigen::Vector3f(x, 0, 0));
  return parts;
}

Result<simulation::LitScene> light(const SceneChoice& choice) {
  if (!choice.person) return simulation::LitScene::make(simulation::make_room());
  auto scene = simulation::make_scene("room");
  if (!scene) return fail(scene.error());
  if (choice.walks) scene->figure.motion = walk;
  return simulation::LitScene::make(std::move(*scene));
}

// A simulated Kinect with the processing of its server and of the client.
class Camera {
 public:
  static Result<Camera> open(const std::shared_ptr<const simulation::LitScene>& scene,
                             const std::vector<Rigid3>& poses, std::size_t index) {
    const CameraModel model = simulation::kinect_model(kCameraWidth, kCameraHeight);
    auto kinect =
        simulation::SimulatedKinect::make(scene, model, poses, index, DepthUnit::kMillimetre, kSeed);
    if (!kinect) return fail(kinect.error());
    auto filler = hole_filling::open(hole_filling::Method::kJoint, hole_filling::Compute::kCpu,
                                     {kCameraWidth, kCameraHeight, DepthUnit::kMillimetre, kRange});
    if (!filler) return fail(filler.error());
    return Camera(std::move(*kinect), std::move(*filler), poses[index]);
  }

  // `versions` counts all frames that have ever been drawn.
  Result<void> capture(double phase, std::uint64_t frame, std::uint64_t& versions) {
    frame_.color.emplace();
    kinect_.capture(phase, frame, frame_.depth, *frame_.color);
    frame_.state = StateImage(kCameraWidth, kCameraHeight, DepthState::kMeasured);
    server::clip_to_range(frame_, to_units(kRange, DepthUnit::kMillimetre));
    if (auto filled = filler_->fill(frame_); !filled) return filled;
    depth_filter_.apply(frame_.depth, frame_.state);
    color::rgb_to_yuv420(*frame_.color, coded_color_);
    color_filter_.apply(coded_color_, depth_filter_.is_camera_moving());
    color::yuv420_to_rgb(coded_color_, *frame_.color);
    conditioner_.apply(frame_);
    background_.learn(frame_);
    const auto covered = background_.covered();
    if (covered != covered_) covered_version_ = ++versions;
    covered_ = covered;
    version_ = ++versions;
    note_farthest();
    return {};
  }

  renderer::CameraView view() const { return view(frame_, version_); }
  // Returns nothing if no remembered background is covered.
  std::optional<renderer::CameraView> remembered_view() const {
    if (!covered_) return std::nullopt;
    auto remembered = view(*covered_, covered_version_);
    remembered.is_remembered = true;
    return remembered;
  }
  color_matching::PosedFrame posed_frame() const {
    return {&frame_, setup_.model, setup_.unit, setup_.noise, *setup_.fixed_pose, kCalibrationErrorM};
  }
  ViewVolume volume() const { return {setup_.model, *setup_.fixed_pose, kRange}; }
  // The farthest surface that each pixel has measured so far; metres, 0 for none.
  const Image<float>& farthest_m() const { return farthest_m_; }

 private:
  renderer::CameraView view(const RgbdFrame& frame, std::uint64_t version) const {
    renderer::CameraView view;
    view.frame = &frame;
    view.version = version;
    view.model = setup_.model;
    view.unit = setup_.unit;
    view.world_from_camera = *setup_.fixed_pose;
    view.calibration_error_m = setup_.calibration_error_m;
    return view;
  }
  void note_farthest() {
    for (std::size_t i = 0; i < farthest_m_.pixels().size(); ++i) {
      if (frame_.state.data()[i] != DepthState::kMeasured) continue;
      farthest_m_.data()[i] = std::max(farthest_m_.data()[i], 1e-3F * float(frame_.depth.data()[i]));
    }
  }

  Camera(simulation::SimulatedKinect kinect, std::unique_ptr<hole_filling::HoleFiller> filler,
         const Rigid3& pose)
      : kinect_(std::move(kinect)), filler_(std::move(filler)) {
    setup_.model = kinect_.model();
    setup_.has_pose = true;
    setup_.fixed_pose = pose;
    setup_.calibration_error_m = kCalibrationErrorM;
    conditioner_.begin(setup_, std::nullopt);
    background_.begin(setup_.unit, setup_.noise);
  }

  simulation::SimulatedKinect kinect_;
  std::unique_ptr<hole_filling::HoleFiller> filler_;
  client::CameraSetup setup_;
  temporal_filter::DepthFilter depth_filter_{kCameraWidth, kCameraHeight, DepthUnit::kMillimetre,
                                             kKinectV1Noise};
  temporal_filter::ColorFilter color_filter_;
  Picture coded_color_;  // Colour as the video encoder takes it, in YUV 4:2:0.
  decoding::FrameConditioner conditioner_;
  RgbdFrame frame_;
  std::uint64_t version_ = 0;
  background_memory::BackgroundMemory background_;
  std::shared_ptr<const RgbdFrame> covered_;
  std::uint64_t covered_version_ = 0;
  Image<float> farthest_m_{kCameraWidth, kCameraHeight};
};

// The viewpoint is that of a single camera, or lies between the first two, a little nearer to the
// person.
renderer::ViewPose eye_among(const std::vector<Rigid3>& poses, const RunSettings& settings) {
  if (poses.size() == 1) return {simulation::kinect_model(kCameraWidth, kCameraHeight), poses[0]};
  const Eigen::Vector3d middle = 0.5 * (poses[0].translation + poses[1].translation);
  const Eigen::Vector3d target =
      0.5 * (poses[0] * Eigen::Vector3d(0, 0, 2.4) + poses[1] * Eigen::Vector3d(0, 0, 2.4));
  renderer::ViewPose eye;
  eye.intrinsics = camera_from_field_of_view(settings.width, settings.height,
                                             settings.fov_degrees / 180 * std::numbers::pi);
  eye.world_from_eye = viewpoint::look_at(middle + 0.2 * (target - middle), target, {0, -1, 0});
  return eye;
}

Image<Rgba8> opaque(const ColorImage& color) {
  Image<Rgba8> result(color.width(), color.height());
  for (std::size_t i = 0; i < color.pixels().size(); ++i) {
    const Rgb8 pixel = color.data()[i];
    result.data()[i] = {pixel.r, pixel.g, pixel.b, 255};
  }
  return result;
}

}  // namespace

std::vector<std::string_view> scene_names() {
  std::vector<std::string_view> names;
  for (const SceneChoice& scene : kScenes) names.push_back(scene.name);
  return names;
}

Result<ViewScore> run_scene(std::string_view name, const RunSettings& settings) {
  const auto* const choice = std::find_if(kScenes.begin(), kScenes.end(),
                                          [&](const SceneChoice& scene) { return scene.name == name; });
  assert(choice != kScenes.end());
  auto lit = light(*choice);
  if (!lit) return fail(lit.error());
  const auto scene = std::make_shared<const simulation::LitScene>(std::move(*lit));
  const std::vector<Rigid3> poses = simulation::kinect_poses(choice->cameras);
  std::vector<Camera> cameras;
  std::vector<ViewVolume> volumes;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    auto camera = Camera::open(scene, poses, i);
    if (!camera) return fail(camera.error());
    volumes.push_back(camera->volume());
    cameras.push_back(std::move(*camera));
  }
  const renderer::ViewPose eye = eye_among(poses, settings);
  auto true_eye = simulation::TrueCamera::make(scene, eye.intrinsics, eye.world_from_eye);
  if (!true_eye) return fail(true_eye.error());

  flow::WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())), "view_bench");
  const auto renderer = renderer::make_cpu_renderer(workers);
  renderer->set_unseen(settings.unseen);
  color_matching::SteadyCorrections corrections(cameras.size());
  ViewError error;
  renderer::MergedView view;
  TrueEyeView truth;
  std::uint64_t versions = 0;
  const int frames = kSettlingFrames + settings.frames;
  for (int frame = 0; frame < frames; ++frame) {
    const double phase = frame % simulation::kPeriodFrames / double(simulation::kPeriodFrames);
    std::vector<color_matching::PosedFrame> posed;
    for (Camera& camera : cameras) {
      if (auto captured = camera.capture(phase, static_cast<std::uint64_t>(frame), versions); !captured)
        return fail(captured.error());
      posed.push_back(camera.posed_frame());
    }
    if (frame == kSettlingFrames / 2)
      corrections.follow(color_matching::match_colors(posed), std::chrono::seconds(1));
    std::vector<renderer::CameraView> views;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      views.push_back(cameras[i].view());
      views.back().color_correction = corrections.correction(i);
      if (auto remembered = cameras[i].remembered_view()) {
        remembered->color_correction = corrections.correction(i);
        views.push_back(*remembered);
      }
    }
    if (frame < kSettlingFrames) continue;
    if (auto drawn = renderer->render(views, eye, {.color = true, .depth = true}, view); !drawn)
      return fail(drawn.error());
    for (std::size_t i = 0; i < cameras.size(); ++i) volumes[i].farthest_m = &cameras[i].farthest_m();
    truth = describe_truth(true_eye->trace(phase), eye, volumes);
    error.add(truth, view, frame > kSettlingFrames);
  }
  if (!settings.pictures.empty()) {
    const std::filesystem::path folder(settings.pictures);
    for (const auto& [suffix, image] :
         {std::pair("view", view.color), std::pair("truth", opaque(truth.color))}) {
      if (auto written =
              display::write_png((folder / fmt::format("{}_{}.png", name, suffix)).string(), image);
          !written) {
        return fail(written.error());
      }
    }
  }
  return error.score();
}

}  // namespace copresence::view_bench
