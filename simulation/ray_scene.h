#pragma once

// Where rays end among triangles. The home of Embree.
//
// Thread: making and posing want one thread at a time; tracing does not change a scene and may go on in
// several.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/result.h"
#include "simulation/mesh.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace copresence::simulation {

/// A ray and, after tracing, what it met first. Directions need no unit length: `far` counts in lengths of
/// `direction`.
struct Ray {
  Eigen::Vector3f origin, direction;
  float near = 1e-4f, far = 1e30f;  ///< far becomes the distance of the hit
  int mesh = -1;                    ///< that was hit, or -1 for none
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  ///< weights of the triangle's second and third vertex
};

struct FreeScene {
  void operator()(RTCSceneTy* scene) const;
};
struct FreeDevice {
  void operator()(RTCDeviceTy* device) const;
};

/// Meshes that never move.
class RayScene {
 public:
  /// Fails  kUnsupported when Embree cannot be started.
  static Result<RayScene> make(std::span<const Mesh> meshes);

  /// Neighbouring rays should look in similar directions: they go eight at a time.
  void trace(std::span<Ray> rays) const;

  /// Whether something lies between near and far.
  bool is_blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near,
                  float far) const;

 private:
  friend class PosedScene;
  std::shared_ptr<RTCDeviceTy> device_;
  std::unique_ptr<RTCSceneTy, FreeScene> scene_;
};

/// Rigid parts that move: each is a mesh with a place of its own. Distinct objects may share parts.
class PosedScene {
 public:
  /// The parts' own geometry, built once.
  class Parts {
   public:
    static Result<Parts> make(std::span<const Mesh> meshes);
    std::size_t size() const { return scenes_.size(); }

   private:
    friend class PosedScene;
    std::shared_ptr<RTCDeviceTy> device_;
    std::vector<std::shared_ptr<RTCSceneTy>> scenes_;
  };

  explicit PosedScene(const Parts& parts);

  /// Puts part i to world_from_part[i]. Requires as many as there are parts.
  void pose(std::span<const Eigen::Isometry3f> world_from_part);

  /// As RayScene::trace(); `mesh` is the part.
  void trace(std::span<Ray> rays) const;

 private:
  std::shared_ptr<RTCDeviceTy> device_;
  std::vector<std::shared_ptr<RTCSceneTy>> parts_;
  std::unique_ptr<RTCSceneTy, FreeScene> scene_;
};

}  // namespace copresence::simulation
