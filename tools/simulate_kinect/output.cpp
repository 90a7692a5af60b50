#include "tools/simulate_kinect/output.h"

#include <fmt/format.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/scene/write_scene.h"

namespace copresence::simulate_kinect {

std::string scene_toml(const CameraModel& model, std::span<const Rigid3> poses, const std::string& made_by) {
  scene::Scene scene;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    scene::Camera& camera = scene.cameras.emplace_back();
    camera.name = fmt::format("camera{}", i);
    camera.address = fmt::format("127.0.0.1:{}", 7001 + i);
    camera.model = model;
    camera.world_from_camera = poses[i];
    camera.source = camera.name + ".oni";
  }
  return fmt::format(
             "# Made by: {}\n# The world frame is x right, y down, z forward, with the floor at y = 0.\n",
             made_by) +
         scene::to_toml(scene, "scene.toml");
}

Result<void> write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text << std::flush;
  if (!file)
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: cannot be written; is the disk full?", path.string()));
  return {};
}

Result<void> write_truth(const std::filesystem::path& folder, int frame, const simulation::TrueView& view) {
  cv::Mat depth(view.depth_m.height(), view.depth_m.width(), CV_16UC1);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const float units = view.depth_m(x, y) * 10000.0f + 0.5f;
      depth.at<std::uint16_t>(y, x) = units < 65536.0f ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
    }
  }
  const cv::Mat rgb(view.color.height(), view.color.width(), CV_8UC3, const_cast<Rgb8*>(view.color.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  for (const auto& [kind, image] : {std::pair{"depth", depth}, std::pair{"color", bgr}}) {
    const auto path = folder / fmt::format("{}_{:04}.png", kind, frame);
    if (!cv::imwrite(path.string(), image)) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("{}: cannot be written; is the disk full?", path.string()));
    }
  }
  return {};
}

}  // namespace copresence::simulate_kinect
