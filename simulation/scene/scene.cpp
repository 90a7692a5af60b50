#include "simulation/scene/scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "simulation/scene/calibration_worlds.h"

namespace copresence::simulation {

std::vector<std::string> world_names() {
  return {"room", "empty-room", "markers", "board", "still-board"};
}

Result<Scene> make_scene(std::string_view name) {
  if (name == "markers") return make_marker_room();
  if (name == "still-board") return make_still_board_room();
  if (name == "empty-room") return make_room();
  Scene scene;
  if (name == "board") {
    scene = make_bare_room();
    scene.figure = make_moving_board(scene);
  } else if (name == "room") {
    scene = make_room();
    scene.figure = make_person(scene);
  } else {
    std::string all;
    for (const std::string& known : world_names()) all += (all.empty() ? "" : ", ") + known;
    return fail(ErrorCode::kInvalid, "there is no world \"" + std::string(name) + "\"; there are " + all);
  }
  return scene;
}

double phase_of_frame(std::uint64_t frame, std::uint64_t frames) {
  assert(frames > 0);
  const std::uint64_t periods = std::max<std::uint64_t>(1, (frames + kPeriodFrames / 2) / kPeriodFrames);
  // With the integer remainder first, `frame` and `frame` + `frames` give the same double.
  return static_cast<double>(frame * periods % frames) / static_cast<double>(frames);
}

Rigid3 look_from(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitY().cross(z).normalized();
  Rigid3 pose;
  pose.rotation << x, z.cross(x), z;
  pose.translation = eye;
  return pose;
}

std::vector<Rigid3> kinect_poses(int count) {
  assert(count >= 1 && count <= kMostKinects);
  // Direction of each camera, in degrees from the direction that the figure faces.
  static constexpr double kAround[] = {-35, 35, 142, -142, 0, 90, -90, 180};
  static constexpr double kDistance[] = {2.35, 2.35, 2.2, 2.2, 2.25, 2.3, 2.3, 2.1};  // In metres.
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = kAround[i] * std::numbers::pi / 180;
    poses.push_back(
        look_from({kDistance[i] * std::sin(angle), -1.5, -kDistance[i] * std::cos(angle)}, {0, -0.95, 0}));
  }
  return poses;
}

}  // namespace copresence::simulation
