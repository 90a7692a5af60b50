#pragma once

// A simulated scene: its static surfaces, its lights, the figure that moves in it, and the poses of
// its cameras. A scene is known to users by the name of its world, such as "room" or "markers".
//
// The world frame is x right, y down, z forward, in metres, with the floor at y = 0. The figure
// stands at the origin and faces -z.
//
// Thread: values; free functions are safe anywhere.

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/scene/figure.h"
#include "simulation/scene/material.h"
#include "simulation/scene/mesh.h"

namespace copresence::simulation {

/// A light-emitting rectangle: center +- half_u +- half_v. Seen from the front of the rectangle, u
/// points right and v points down.
struct AreaLight {
  Eigen::Vector3f center, half_u, half_v;
  Eigen::Vector3f power;  ///< Irradiance of a facing surface one metre away, linear colour.

  /// Returns the unit normal of the front.
  Eigen::Vector3f front() const { return half_v.cross(half_u).normalized(); }
};

struct Scene {
  std::vector<Material> materials;
  std::vector<Mesh> meshes;       ///< Static surfaces in the world frame.
  std::vector<AreaLight> lights;  ///< Only the first light casts shadows of the figure.
  /// Light from all directions, before occlusion.
  Eigen::Vector3f ambient = Eigen::Vector3f::Constant(0.1f);
  Figure figure;  ///< May be empty.

  /// Adds a material and returns its index.
  int add(const Material& material) {
    materials.push_back(material);
    return static_cast<int>(materials.size()) - 1;
  }
  void add(Mesh mesh) { meshes.push_back(std::move(mesh)); }
};

std::vector<std::string> world_names();

/// Returns the scene of a world. Fails with kInvalid if world_names() does not contain `name`.
Result<Scene> make_scene(std::string_view name);

/// The world "room" without its person: a furnished living room of 4.8 m x 4.5 m x 2.6 m around the
/// origin. Its middle is free. A dark screen, a window and a mirror-like vase reflect little
/// infrared light to a Kinect.
Scene make_room();

/// The period of the figure's motion in frames, at 30 frames per second.
inline constexpr int kPeriodFrames = 60;

/// The phase of frame `frame` (from 0) of a recording of `frames` frames that loops without a seam.
/// The period is stretched to fill the recording a whole number of times. Requires frames > 0.
double phase_of_frame(std::uint64_t frame, std::uint64_t frames);

inline constexpr int kMostKinects = 8;

/// The poses world_from_camera of `count` Kinects around the figure, all aimed at it, in metres.
/// The first two Kinects are 70 degrees apart in front of the figure, the third and fourth behind
/// it. Requires `count` from 1 to kMostKinects.
std::vector<Rigid3> kinect_poses(int count);

/// Returns the upright pose at `eye` that faces `target`. Requires that neither is above the other.
Rigid3 look_from(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

}  // namespace copresence::simulation
