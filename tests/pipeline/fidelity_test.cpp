// Measures the loss of quality by network and codecs. The picture of real processes is compared
// with a picture rendered from the uncoded frames of the same recording. The viewpoint is 20
// degrees beside the cameras.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>

#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/sensor/source.h"
#include "capture_server/temporal_filter/color_filter.h"
#include "capture_server/temporal_filter/depth_filter.h"
#include "common/color/yuv420.h"
#include "common/flow/worker_pool.h"
#include "common/scene/scene.h"
#include "common/wire/frame_client.h"
#include "render_client/decoding/depth_smoothing.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/viewpoint/look_at.h"
#include "tests/pipeline/running_room.h"
#include "tests/support/real_recordings.h"

namespace copresence::testing {
namespace {

constexpr int kWidth = 1280, kHeight = 720;

struct Difference {
  double psnr = 0;              ///< In dB, over pixels that both pictures show.
  double only_one_percent = 0;  ///< Share of pixels that only one picture shows.
};

class Fidelity : public ::testing::Test {
 protected:
  /// Serves the scene's cameras, looks from 20 degrees beside the first, and compares.
  Difference measure(const std::filesystem::path& scene_file) {
    const auto loaded = scene::load(scene_file);
    EXPECT_TRUE(loaded) << loaded.error().what;
    const scene::Scene& scene = *loaded;
    std::vector<SentFrames> sent(scene.cameras.size());
    std::vector<std::jthread> listeners;
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
      const scene::Camera& camera = scene.cameras[i];
      room_.serve(camera.source, {"--loop", "--name", camera.name, "--scene", scene_file});
      listeners.emplace_back(listen, room_.address(i), std::ref(sent[i]));
    }
    const Rigid3 world_from_eye = beside(*scene.cameras[0].world_from_camera, scene.up);
    const auto stats = room_.view({"--scene", scene_file, "--color-matching", "off", "--unseen", "black",
                                   "--view", "path:" + path_file(world_from_eye), "--frames", "60", "--size",
                                   fmt::format("{}x{}", kWidth, kHeight)});
    listeners.clear();
    if (stats.is_null()) return {};
    std::vector<std::uint64_t> shown;
    for (const auto& camera : stats["cameras"]) shown.push_back(camera["last_shown_sequence"]);
    const cv::Mat streamed = cv::imread(room_.picture().string()),
                  undecoded = reference(scene, shown, sent, world_from_eye);
    if (const char* folder = std::getenv("COPRESENCE_KEEP_PICTURES")) {  // Keeps both pictures.
      cv::imwrite(std::string(folder) + "/streamed.png", streamed);
      cv::imwrite(std::string(folder) + "/undecoded.png", undecoded);
    }
    return compare(streamed, undecoded);
  }

  RunningRoom room_;

 private:
  static constexpr double kPivotM = 2.0;

  /// Sequence numbers: what is shown depends on the frames before, and a busy machine leaves some
  /// out.
  using SentFrames = std::set<std::uint64_t>;

  static void listen(const std::stop_token& stop, const std::string& address, SentFrames& sent) {
    while (!stop.stop_requested()) {
      auto client = wire::FrameClient::connect(address, std::chrono::seconds(1), stop);
      while (client) {
        const auto received = client->receive(stop);
        if (!received) break;
        sent.insert(received->frame.sequence);
      }
    }
  }

  static Rigid3 beside(const Rigid3& world_from_camera, const Eigen::Vector3d& up) {
    const Eigen::Vector3d pivot = world_from_camera * Eigen::Vector3d(0, 0, kPivotM);
    const Eigen::AngleAxisd turn(20 * std::numbers::pi / 180, up);
    return viewpoint::look_at(pivot + turn * (world_from_camera.translation - pivot), pivot, up);
  }

  std::string path_file(const Rigid3& world_from_eye) {
    const Eigen::Vector3d at = world_from_eye.translation,
                          look = world_from_eye * Eigen::Vector3d(0, 0, kPivotM);
    std::ofstream(room_.file("eye.path"))
        << fmt::format("0 {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", at.x(), at.y(), at.z(),
                       look.x(), look.y(), look.z());
    return room_.file("eye.path").string();
  }

  /// What the client would show of the frame with this sequence number, had it got uncoded what was
  /// sent up to it.
  static RgbdFrame shown_frame(const scene::Camera& camera, std::uint64_t sequence, const SentFrames& sent) {
    auto source = sensor::open_source(camera.source, {sensor::SourceSettings::Pace::kFast, true});
    EXPECT_TRUE(source) << source.error().what;
    const DepthUnit unit = (*source)->description().unit;
    const auto filler = hole_filling::open(hole_filling::Method::kJoint, hole_filling::Compute::kCpu,
                                           {camera.model.width, camera.model.height, unit, DepthRange{}});
    temporal_filter::DepthFilter depth_filter(camera.model.width, camera.model.height, unit, kKinectV1Noise);
    temporal_filter::ColorFilter color_filter;
    RgbdFrame frame;
    while (frame.metadata.sequence < sequence) {
      frame = *(*source)->next({});
      if (!sent.contains(frame.metadata.sequence)) continue;
      server::clip_to_range(frame, to_units(DepthRange{}, unit));
      EXPECT_TRUE((*filler)->fill(frame));
      depth_filter.apply(frame.depth, frame.state);
      Picture coded;
      color::rgb_to_yuv420(*frame.color, coded);
      color_filter.apply(coded, depth_filter.is_camera_moving());
      color::yuv420_to_rgb(coded, *frame.color);
    }
    decoding::DepthSmoothing().smooth(frame.depth, unit, kKinectV1Noise);
    return frame;
  }

  static cv::Mat reference(const scene::Scene& scene, const std::vector<std::uint64_t>& sequences,
                           const std::vector<SentFrames>& sent, const Rigid3& world_from_eye) {
    std::vector<RgbdFrame> frames;
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
      frames.push_back(shown_frame(scene.cameras[i], sequences[i], sent[i]));
    }
    std::vector<renderer::CameraView> views;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      renderer::CameraView view;
      view.frame = &frames[i];
      view.version = 1;
      view.model = scene.cameras[i].model;
      view.world_from_camera = *scene.cameras[i].world_from_camera;
      if (scene.cameras[i].calibration_error_mm) {
        view.calibration_error_m = *scene.cameras[i].calibration_error_mm * 1e-3;
      }
      views.push_back(view);
    }
    flow::WorkerPool workers(2, "reference");
    viewpoint::ViewPose eye;
    eye.intrinsics = camera_from_field_of_view(kWidth, kHeight, 50 * std::numbers::pi / 180);
    eye.world_from_eye = world_from_eye;
    renderer::MergedView merged;
    EXPECT_TRUE(renderer::make_cpu_renderer(workers)->render(views, eye, {.color = true}, merged));
    cv::Mat bgr;
    cv::cvtColor(cv::Mat(kHeight, kWidth, CV_8UC4, merged.color.data()), bgr, cv::COLOR_RGBA2BGR);
    return bgr;
  }

  static Difference compare(const cv::Mat& streamed, const cv::Mat& undecoded) {
    EXPECT_EQ(streamed.size(), undecoded.size());
    if (streamed.size() != undecoded.size()) return {};
    double squares = 0;
    int both = 0, only_one = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const auto a = streamed.at<cv::Vec3b>(y, x), b = undecoded.at<cv::Vec3b>(y, x);
        const bool in_a = a != cv::Vec3b(0, 0, 0), in_b = b != cv::Vec3b(0, 0, 0);
        only_one += in_a != in_b;
        if (!in_a || !in_b) continue;
        ++both;
        for (int c = 0; c < 3; ++c) squares += (a[c] - b[c]) * (a[c] - b[c]);
      }
    }
    EXPECT_GT(both, kWidth * kHeight / 4);
    const double mse = squares / (3.0 * std::max(both, 1));
    const Difference difference{10 * std::log10(255.0 * 255.0 / std::max(mse, 1e-6)),
                                100.0 * only_one / (both + only_one)};
    std::cout << fmt::format("PSNR {:.1f} dB over {} pixels, {:.2f} % shown in only one\n", difference.psnr,
                             both, difference.only_one_percent);
    return difference;
  }
};

TEST_F(Fidelity, StreamedAndUndecodedViewsOfTheSimulatedRoomAgree) {
  const Difference difference = measure(recordings() / "scene.toml");
  EXPECT_GE(difference.psnr, 30.0);
  EXPECT_LE(difference.only_one_percent, 1.0);
}

TEST_F(Fidelity, StreamedAndUndecodedViewsOfARealOfficeAgree) {
  const auto views_file = test::real_recording("office_views.json");
  if (!views_file) {
    GTEST_SKIP() << "SKIPPED: the real recordings are not on this machine (set COPRESENCE_RECORDINGS)";
  }
  const auto folder = std::filesystem::absolute(*views_file).parent_path();
  std::ifstream file(*views_file);
  const auto views = nlohmann::json::parse(file);
  std::ofstream scene(room_.file("scene.toml"));
  for (const auto& camera : views["cameras"]) {
    const auto& k = views["intrinsics"];
    scene << fmt::format(
        "[[camera]]\nname = \"{0}\"\nsource = \"{1}\"\nwidth = 640\nheight = 480\nfx = {2}\nfy = {3}\ncx = "
        "{4}\n"
        "cy = {5}\nworld_from_camera = {6}\n",
        camera["file"].get<std::string>(), (folder / camera["file"]).string(), k["fx"].get<double>(),
        k["fy"].get<double>(), k["cx"].get<double>(), k["cy"].get<double>(),
        camera["world_from_camera"].dump());
  }
  scene.close();
  const Difference difference = measure(room_.file("scene.toml"));
  EXPECT_GE(difference.psnr, 30.0);
  EXPECT_LE(difference.only_one_percent, 1.5);  // Errors of the codec at depth edges.
}

}  // namespace
}  // namespace copresence::testing
