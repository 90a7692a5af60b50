#include "tools/view_bench/room_views.h"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
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
#include "render_client/moving_surfaces/moving_surfaces.h"
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

enum class Person { kNone, kStands, kWalks, kWaves };

struct SceneChoice {
  std::string_view name;
  int cameras;
  Person person;
  int turns;  // Number of instants in a frame period at which cameras capture, one after the other.
};

constexpr std::array kScenes{
    SceneChoice{"empty", 2, Person::kNone, 1},    SceneChoice{"standing", 2, Person::kStands, 1},
    SceneChoice{"walking", 2, Person::kWalks, 1}, SceneChoice{"four", 4, Person::kStands, 1},
    SceneChoice{"own", 1, Person::kStands, 1},    SceneChoice{"waving", 2, Person::kWaves, 2},
};

std::vector<Eigen::Isometry3f> stand(double phase) {
  static const auto motion = simulation::make_scene("room")->figure.motion;
  return motion(phase);
}

// The person moves twice as fast, so that the waving hand reaches 2 m/s.
std::vector<Eigen::Isometry3f> wave(double phase) {
  return stand(2 * phase);
}

// The person walks on the spot, and is carried 2 m through the middle of the room and back.
std::vector<Eigen::Isometry3f> walk(double phase) {
  constexpr float kHalfWayM = 1.0F;
  const auto x = static_cast<float>(kHalfWayM * std::sin(2 * std::numbers::pi * phase));
  auto parts = stand(phase);
  for (Eigen::Isometry3f& part : parts) part.pretranslate(Eigen::Vector3f(x, 0, 0));
  return parts;
}

Result<simulation::LitScene> light(const SceneChoice& choice) {
  if (choice.person == Person::kNone) return simulation::LitScene::make(simulation::make_room());
  auto scene = simulation::make_scene("room");
  if (!scene) return fail(scene.error());
  if (choice.person == Person::kWalks) scene->figure.motion = walk;
  if (choice.person == Person::kWaves) scene->figure.motion = wave;
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
    moving_ = motion_.detect(frame_.depth);
    shown_ = frame_;
    const auto covered = background_.covered();
    if (covered != covered_) covered_version_ = ++versions;
    covered_ = covered;
    version_ = ++versions;
    note_farthest();
    return {};
  }

  // The whole frame.
  renderer::CameraView view() const { return view(frame_, version_); }
  // The frame without the moving surfaces that other cameras show.
  renderer::CameraView shown_view() const { return view(shown_, version_); }
  moving_surfaces::CameraMotion motion() const { return {shown_view(), &moving_}; }
  RgbdFrame& shown() { return shown_; }
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
  ViewVolume volume() const { return {setup_.model, *setup_.fixed_pose, kRange, &farthest_m_}; }

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
    motion_.begin(setup_.unit, setup_.noise);
  }

  simulation::SimulatedKinect kinect_;
  std::unique_ptr<hole_filling::HoleFiller> filler_;
  client::CameraSetup setup_;
  temporal_filter::DepthFilter depth_filter_{kCameraWidth, kCameraHeight, DepthUnit::kMillimetre,
                                             kKinectV1Noise};
  temporal_filter::ColorFilter color_filter_;
  Picture coded_color_;  // Colour as the video encoder takes it, in YUV 4:2:0.
  decoding::FrameConditioner conditioner_;
  RgbdFrame frame_, shown_;
  std::uint64_t version_ = 0;
  moving_surfaces::MotionDetector motion_;
  moving_surfaces::MovingBlocks moving_;
  background_memory::BackgroundMemory background_;
  std::shared_ptr<const RgbdFrame> covered_;
  std::uint64_t covered_version_ = 0;
  // The farthest surface that each pixel has measured so far; metres, 0 for none.
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

// One scene with its cameras, at successive instants.
class Room {
 public:
  static Result<Room> open(const SceneChoice& choice, const RunSettings& settings, Executor& workers) {
    auto lit = light(choice);
    if (!lit) return fail(lit.error());
    const auto scene = std::make_shared<const simulation::LitScene>(std::move(*lit));
    const std::vector<Rigid3> poses = simulation::kinect_poses(choice.cameras);
    std::vector<Camera> cameras;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      auto camera = Camera::open(scene, poses, i);
      if (!camera) return fail(camera.error());
      cameras.push_back(std::move(*camera));
    }
    const renderer::ViewPose eye = eye_among(poses, settings);
    auto true_eye = simulation::TrueCamera::make(scene, eye.intrinsics, eye.world_from_eye);
    if (!true_eye) return fail(true_eye.error());
    return Room(choice, settings, std::move(cameras), eye, std::move(*true_eye), workers);
  }

  // Captures the frames of the cameras whose turn it is. Instants are numbered from 0.
  Result<void> capture(int instant) {
    phase_ =
        std::fmod(double(instant) / choice_.turns, simulation::kPeriodFrames) / simulation::kPeriodFrames;
    const int frame = instant / choice_.turns, turn = instant % choice_.turns;
    for (std::size_t i = turn; i < cameras_.size(); i += choice_.turns) {
      if (auto captured = cameras_[i].capture(phase_, static_cast<std::uint64_t>(frame), versions_);
          !captured)
        return captured;
      // Cameras with one turn capture together, and the client merges their moving surfaces.
      if (choice_.turns == 1 || instant < choice_.turns) continue;
      std::vector<std::optional<moving_surfaces::CameraMotion>> motions;
      for (const Camera& camera : cameras_) motions.emplace_back(camera.motion());
      moving_.leave_out(cameras_[i].shown(), i, motions);
    }
    return {};
  }

  void match_colors() {
    std::vector<color_matching::PosedFrame> posed;
    for (const Camera& camera : cameras_) posed.push_back(camera.posed_frame());
    corrections_.follow(color_matching::match_colors(posed), std::chrono::seconds(1));
  }

  // Draws a view and compares it with the truth. `is_next` as in ViewError::add().
  Result<void> score_view(bool is_next) {
    describe_truth();
    std::vector<renderer::CameraView> views;
    for (std::size_t i = 0; i < cameras_.size(); ++i) add_views(i, cameras_[i].shown_view(), views);
    if (auto drawn = renderer_->render(views, eye_, kPixels, view_); !drawn) return drawn;
    error_.add(truth_, view_, is_next);
    for (std::size_t i = 0; i < alone_.size(); ++i) {
      views.clear();
      add_views(i, cameras_[i].view(), views);
      renderer::MergedView view;
      if (auto drawn = alone_[i].renderer->render(views, eye_, kPixels, view); !drawn) return drawn;
      TrueEyeView truth = truth_;
      for (std::size_t p = 0; p < truth.is_moving.pixels().size(); ++p)
        truth.is_moving.data()[p] &= view.origin.data()[p] == renderer::Origin::kSeen;
      alone_[i].error.add(truth, view, is_next);
      alone_[i].together.add(truth, view_, is_next);
    }
    return {};
  }

  SceneResult result() const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    SceneResult result{error_.score(), kNone, kNone};
    for (const Alone& alone : alone_) {
      const double psnr = alone.error.score().psnr_moving;
      if (psnr < result.psnr_alone) continue;
      result.psnr_alone = psnr;
      result.psnr_together = alone.together.score().psnr_moving;
    }
    return result;
  }

  const Image<Rgba8>& view() const { return view_.color; }
  const ColorImage& truth() const { return truth_.color; }

 private:
  static constexpr renderer::HostPixels kPixels{.color = true, .depth = true};
  // The errors of one camera alone, and of all cameras, over the pixels that this camera sees.
  struct Alone {
    std::unique_ptr<renderer::Renderer> renderer;
    ViewError error, together;
  };

  Room(const SceneChoice& choice, const RunSettings& settings, std::vector<Camera> cameras,
       const renderer::ViewPose& eye, simulation::TrueCamera true_eye, Executor& workers)
      : choice_(choice),
        cameras_(std::move(cameras)),
        eye_(eye),
        true_eye_(std::move(true_eye)),
        moving_(cameras_.size()),
        corrections_(cameras_.size()),
        renderer_(renderer::make_cpu_renderer(workers)) {
    renderer_->set_unseen(settings.unseen);
    for (std::size_t i = 0; choice.turns > 1 && i < cameras_.size(); ++i) {
      alone_.push_back({renderer::make_cpu_renderer(workers), {}, {}});
      alone_.back().renderer->set_unseen(settings.unseen);
    }
  }

  void add_views(std::size_t camera, const renderer::CameraView& newest,
                 std::vector<renderer::CameraView>& views) const {
    views.push_back(newest);
    views.back().color_correction = corrections_.correction(camera);
    if (auto remembered = cameras_[camera].remembered_view()) {
      remembered->color_correction = corrections_.correction(camera);
      views.push_back(*remembered);
    }
  }

  void describe_truth() {
    std::vector<ViewVolume> volumes;
    for (const Camera& camera : cameras_) volumes.push_back(camera.volume());
    truth_ = view_bench::describe_truth(true_eye_.trace(phase_), eye_, volumes);
    true_depths_.push_back(truth_.depth_m);
    if (static_cast<int>(true_depths_.size()) <= choice_.turns) return;
    truth_.is_moving = moving_region(truth_.depth_m, true_depths_.front());
    true_depths_.pop_front();
  }

  SceneChoice choice_;
  std::vector<Camera> cameras_;
  renderer::ViewPose eye_;
  simulation::TrueCamera true_eye_;
  moving_surfaces::MovingSurfaces moving_;
  color_matching::SteadyCorrections corrections_;
  std::unique_ptr<renderer::Renderer> renderer_;
  std::vector<Alone> alone_;  // Empty unless the cameras take turns.
  std::uint64_t versions_ = 0;
  double phase_ = 0;
  ViewError error_;
  renderer::MergedView view_;
  TrueEyeView truth_;
  std::deque<Image<float>> true_depths_;  // Of the last frame period.
};

}  // namespace

std::vector<std::string_view> scene_names() {
  std::vector<std::string_view> names;
  for (const SceneChoice& scene : kScenes) names.push_back(scene.name);
  return names;
}

Result<SceneResult> run_scene(std::string_view name, const RunSettings& settings) {
  const auto* const choice = std::find_if(kScenes.begin(), kScenes.end(),
                                          [&](const SceneChoice& scene) { return scene.name == name; });
  assert(choice != kScenes.end());
  flow::WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())), "view_bench");
  auto room = Room::open(*choice, settings, workers);
  if (!room) return fail(room.error());
  const int settling = kSettlingFrames * choice->turns;
  for (int instant = 0; instant < settling + settings.frames; ++instant) {
    if (auto captured = room->capture(instant); !captured) return fail(captured.error());
    if (instant == settling / 2) room->match_colors();
    if (instant < settling) continue;
    if (auto scored = room->score_view(instant > settling); !scored) return fail(scored.error());
  }
  if (!settings.pictures.empty()) {
    const std::filesystem::path folder(settings.pictures);
    for (const auto& [suffix, image] :
         {std::pair("view", room->view()), std::pair("truth", opaque(room->truth()))}) {
      if (auto written =
              display::write_png((folder / fmt::format("{}_{}.png", name, suffix)).string(), image);
          !written) {
        return fail(written.error());
      }
    }
  }
  return room->result();
}

}  // namespace copresence::view_bench
