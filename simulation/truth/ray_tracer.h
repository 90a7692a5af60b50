#pragma once

// Casts rays against triangle meshes, static or moving. Only this file uses Embree (3 or 4).
// Thread: build and pose a scene on one thread at a time. Tracing is safe on any thread.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/scene/mesh.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace copresence::simulation {

/// A ray, and its first hit after tracing. `direction` may have any length. `near` and `far` are
/// multiples of the length of `direction`.
struct Ray {
  Eigen::Vector3f origin, direction;
  float near = 1e-4f, far = 1e30f;  ///< Searched range. After a hit, `far` is the distance of the hit.
  int mesh = -1;                    ///< Index of the mesh or part that was hit, or -1 for none.
  std::uint32_t triangle = 0;       ///< Index within the mesh.
  float u = 0, v = 0;               ///< Barycentric weights of the second and third vertex.
};

/// Interpolates a value between the three vertices of the triangle that was hit.
template <class Value>
Value interpolate(const Ray& hit, const Value& a, const Value& b, const Value& c) {
  return a * (1 - hit.u - hit.v) + b * hit.u + c * hit.v;
}

struct SurfacePoint {
  Eigen::Vector3f position, normal;  ///< Both vectors are in the frame of the mesh.
  Eigen::Vector2f uv;
};

/// The surface at the point where a ray hit `mesh`.
inline SurfacePoint surface_at(const Mesh& mesh, const Ray& hit) {
  const auto& t = mesh.triangles[hit.triangle];
  const Vertex &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  return {interpolate(hit, a.position, b.position, c.position),
          interpolate(hit, a.normal, b.normal, c.normal).normalized(), interpolate(hit, a.uv, b.uv, c.uv)};
}

/// The rays through the pixels of a camera.
struct PixelRays {
  /// Requires a model that check() accepts and a rigid pose.
  PixelRays(const CameraModel& model, const Rigid3& world_from_camera);

  std::size_t width() const { return static_cast<std::size_t>(model.width); }
  std::size_t height() const { return static_cast<std::size_t>(model.height); }

  /// Returns the direction through the point that is `offset` pixels from the centre of a pixel.
  Eigen::Vector3f direction(std::size_t pixel, const Eigen::Vector2f& offset) const {
    return directions[pixel] + offset.x() * pixel_x + offset.y() * pixel_y;
  }

  CameraModel model;
  Rigid3 world_from_camera;
  Eigen::Vector3f eye;  ///< Position in the world frame, in metres.
  /// Per pixel, world frame. The component along the optical axis is 1.
  std::vector<Eigen::Vector3f> directions;
  Eigen::Vector3f pixel_x, pixel_y;  ///< Difference of the directions of neighbouring pixels.
};

struct FreeScene {
  void operator()(RTCSceneTy* scene) const;
};
struct FreeDevice {
  void operator()(RTCDeviceTy* device) const;
};

/// Static meshes, ready for tracing.
class RayScene {
 public:
  /// Fails with kUnsupported if Embree cannot start on this processor.
  static Result<RayScene> make(std::span<const Mesh> meshes);

  /// Traces rays in packets of eight. Consecutive rays should have similar directions.
  void trace(std::span<Ray> rays) const;

  /// Returns true if there is a surface between `near` and `far`.
  bool is_blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near,
                  float far) const;

 private:
  std::shared_ptr<RTCDeviceTy> device_;
  std::unique_ptr<RTCSceneTy, FreeScene> scene_;
};

/// Rigid parts that move. Each mesh is an instance with its own pose. Objects share geometry.
class PosedScene {
 public:
  /// The geometry of the parts, which is built only once.
  class Parts {
   public:
    /// Fails as RayScene::make() does.
    static Result<Parts> make(std::span<const Mesh> meshes);
    std::size_t size() const { return scenes_.size(); }

   private:
    friend class PosedScene;
    std::shared_ptr<RTCDeviceTy> device_;
    std::vector<std::shared_ptr<RTCSceneTy>> scenes_;
  };

  explicit PosedScene(const Parts& parts);

  /// Moves each part i to the pose world_from_part[i]. Requires one pose per part.
  void pose(std::span<const Eigen::Isometry3f> world_from_part);

  /// Traces rays as RayScene::trace() does. Ray::mesh is the index of the part.
  void trace(std::span<Ray> rays) const;

 private:
  std::shared_ptr<RTCDeviceTy> device_;
  std::vector<std::shared_ptr<RTCSceneTy>> parts_;
  std::unique_ptr<RTCSceneTy, FreeScene> scene_;
};

}  // namespace copresence::simulation
