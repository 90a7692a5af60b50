#include "simulation/truth/ray_tracer.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cassert>
#include <cstring>

namespace copresence::simulation {
namespace {

Result<std::shared_ptr<RTCDeviceTy>> make_device() {
  // Embree builds on the calling thread. Only the programs create threads.
  std::shared_ptr<RTCDeviceTy> device(rtcNewDevice("threads=1,set_affinity=0"), FreeDevice());
  if (!device)
    return fail(ErrorCode::kUnsupported, "the ray caster Embree cannot be started on this processor");
  return device;
}

void attach_mesh(RTCDevice device, RTCScene scene, const Mesh& mesh) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  for (const Vertex& vertex : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) *points++ = vertex.position[axis];
  }
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                              mesh.triangles.size()));
  std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(std::uint32_t));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

// This function and the next differ between Embree 3 and 4.
void intersect(RTCScene scene, const int* valid, RTCRayHit8& packet) {
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &packet, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, &packet);
#endif
}
void find_any_hit(RTCScene scene, RTCRay& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

void trace_in_packets(RTCScene scene, std::span<Ray> rays, bool instanced) {
  for (std::size_t first = 0; first < rays.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, rays.size() - first);
    alignas(32) int valid[8];
    RTCRayHit8 packet;
    for (std::size_t i = 0; i < 8; ++i) {
      valid[i] = i < count ? -1 : 0;
      const Ray& ray = rays[first + std::min(i, count - 1)];
      packet.ray.org_x[i] = ray.origin.x();
      packet.ray.org_y[i] = ray.origin.y();
      packet.ray.org_z[i] = ray.origin.z();
      packet.ray.dir_x[i] = ray.direction.x();
      packet.ray.dir_y[i] = ray.direction.y();
      packet.ray.dir_z[i] = ray.direction.z();
      packet.ray.tnear[i] = ray.near;
      packet.ray.tfar[i] = ray.far;
      packet.ray.time[i] = 0;
      packet.ray.mask[i] = ~0u;
      packet.ray.id[i] = 0;
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    intersect(scene, valid, packet);
    for (std::size_t i = 0; i < count; ++i) {
      Ray& ray = rays[first + i];
      if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
        ray.mesh = -1;
        continue;
      }
      ray.far = packet.ray.tfar[i];
      ray.mesh = static_cast<int>(instanced ? packet.hit.instID[0][i] : packet.hit.geomID[i]);
      ray.triangle = packet.hit.primID[i];
      ray.u = packet.hit.u[i];
      ray.v = packet.hit.v[i];
    }
  }
}

}  // namespace

PixelRays::PixelRays(const CameraModel& camera, const Rigid3& pose)
    : model(camera), world_from_camera(pose), eye(pose.translation.cast<float>()) {
  const Eigen::Matrix3f rotation = pose.rotation.cast<float>();
  for (const Eigen::Vector2f& ray : rays(model))
    directions.push_back(rotation * Eigen::Vector3f(ray.x(), ray.y(), 1));
  pixel_x = rotation.col(0) / static_cast<float>(model.fx);
  pixel_y = rotation.col(1) / static_cast<float>(model.fy);
}

void FreeScene::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}
void FreeDevice::operator()(RTCDeviceTy* device) const {
  rtcReleaseDevice(device);
}

Result<RayScene> RayScene::make(std::span<const Mesh> meshes) {
  auto device = make_device();
  if (!device) return fail(device.error());
  RayScene made;
  made.device_ = *device;
  made.scene_.reset(rtcNewScene(made.device_.get()));
  // Without this flag, rays may pass between two triangles with a common edge.
  rtcSetSceneFlags(made.scene_.get(), RTC_SCENE_FLAG_ROBUST);
  for (const Mesh& mesh : meshes) attach_mesh(made.device_.get(), made.scene_.get(), mesh);
  rtcCommitScene(made.scene_.get());
  return made;
}

void RayScene::trace(std::span<Ray> rays) const {
  trace_in_packets(scene_.get(), rays, false);
}

bool RayScene::is_blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near,
                          float far) const {
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = near;
  ray.tfar = far;
  ray.mask = ~0u;
  find_any_hit(scene_.get(), ray);
  return ray.tfar < 0;
}

Result<PosedScene::Parts> PosedScene::Parts::make(std::span<const Mesh> meshes) {
  auto device = make_device();
  if (!device) return fail(device.error());
  Parts parts;
  parts.device_ = *device;
  for (const Mesh& mesh : meshes) {
    const std::shared_ptr<RTCSceneTy> scene(rtcNewScene(parts.device_.get()), FreeScene());
    attach_mesh(parts.device_.get(), scene.get(), mesh);
    rtcCommitScene(scene.get());
    parts.scenes_.push_back(scene);
  }
  return parts;
}

PosedScene::PosedScene(const Parts& parts) : device_(parts.device_), parts_(parts.scenes_) {
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_DYNAMIC);
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_LOW);
  for (const auto& part : parts_) {
    const RTCGeometry instance = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, part.get());
    rtcSetGeometryTimeStepCount(instance, 1);
    rtcCommitGeometry(instance);
    rtcAttachGeometry(scene_.get(), instance);
    rtcReleaseGeometry(instance);
  }
  rtcCommitScene(scene_.get());
}

void PosedScene::pose(std::span<const Eigen::Isometry3f> world_from_part) {
  assert(world_from_part.size() == parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const RTCGeometry instance = rtcGetGeometry(scene_.get(), static_cast<unsigned>(i));
    const Eigen::Matrix4f matrix = world_from_part[i].matrix();  // Column-major order.
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, matrix.data());
    rtcCommitGeometry(instance);
  }
  rtcCommitScene(scene_.get());
}

void PosedScene::trace(std::span<Ray> rays) const {
  trace_in_packets(scene_.get(), rays, true);
}

}  // namespace copresence::simulation
