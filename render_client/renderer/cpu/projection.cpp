#include "render_client/renderer/cpu/projection.h"

#include <algorithm>

#include "render_client/renderer/cpu/lanes.h"

namespace copresence::renderer {

ProjectionMatrix projection_matrix(const ViewPose& eye, const Rigid3& world_from_camera) {
  const Rigid3 eye_from_camera = eye.world_from_eye.inverse() * world_from_camera;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = eye.intrinsics.fx;
  K(1, 1) = eye.intrinsics.fy;
  K(0, 2) = eye.intrinsics.cx;
  K(1, 2) = eye.intrinsics.cy;
  Eigen::Matrix<double, 3, 4> Rt;
  Rt << eye_from_camera.rotation, eye_from_camera.translation;
  return (K * Rt).cast<float>();
}

ClipVertex project(const DepthMesh& mesh, std::size_t vertex, const ProjectionMatrix& m) {
  const float x = mesh.x[vertex], y = mesh.y[vertex], w = mesh.w[vertex];
  const auto row = [&](int r) { return m(r, 0) * x + m(r, 1) * y + (m(r, 3) * w + m(r, 2)); };
  return {row(0), row(1), row(2), w, mesh.u[vertex], mesh.v[vertex]};
}

ViewVertex to_view(const ClipVertex& vertex) {
  const float k = 1.0F / vertex.z;
  return {.x = vertex.x * k,
          .y = vertex.y * k,
          .pad = {},
          .w = vertex.w * k,
          .k = k,
          .u = (kTexelSteps * vertex.u + 0.5F) * k,
          .v = (kTexelSteps * vertex.v + 0.5F) * k};
}

namespace {

// A group of eight vertices. The last group of a patch may have fewer vertices.
struct Group {
  Floats x, y, w, k, u, v;
  Ints in_front;

  Group(const DepthMesh& mesh, std::size_t first, const ProjectionMatrix& m, float near_m) {
    const Floats ray_x = load<Floats>(mesh.x.data() + first), ray_y = load<Floats>(mesh.y.data() + first);
    const Floats inverse = load<Floats>(mesh.w.data() + first);
    const auto row = [&](int r) { return m(r, 0) * ray_x + m(r, 1) * ray_y + (m(r, 3) * inverse + m(r, 2)); };
    const Floats z = row(2);
    in_front = (z > 0) & (z >= near_m * inverse);
    k = 1.0F / z;
    x = row(0) * k;
    y = row(1) * k;
    w = inverse * k;
    u = (kTexelSteps * load<Floats>(mesh.u.data() + first) + 0.5F) * k;
    v = (kTexelSteps * load<Floats>(mesh.v.data() + first) + 0.5F) * k;
  }
};

float least(const Floats& v) {
  float result = v[0];
  for (int lane = 1; lane < kLanes; ++lane) result = std::min(result, v[lane]);
  return result;
}

}  // namespace

void project_patches(const DepthMesh& mesh, std::size_t begin, std::size_t end,
                     const ProjectionMatrix& matrix, float near_m, std::vector<ViewVertex>& vertices,
                     std::vector<PatchExtent>& extents) {
  const Floats infinity = all(std::numeric_limits<float>::infinity());
  for (std::size_t p = begin; p < end; ++p) {
    const DepthMesh::Patch& patch = mesh.patches[p];
    Floats left = infinity, top = infinity, minus_right = infinity, minus_bottom = infinity;
    unsigned in_front = 0, behind = 0;
    for (std::uint32_t i = 0; i < patch.vertices; i += kLanes) {
      const Group group(mesh, patch.first_vertex + i, matrix, near_m);
      const int count = std::min<int>(kLanes, static_cast<int>(patch.vertices - i));
      const Ints valid = group.in_front & (ramp() < static_cast<float>(count));
      const unsigned here = (1U << count) - 1, shown = bits(valid);
      in_front |= shown;
      behind |= here & ~shown;
      left = smaller(valid ? group.x : infinity, left);
      top = smaller(valid ? group.y : infinity, top);
      minus_right = smaller(valid ? -group.x : infinity, minus_right);
      minus_bottom = smaller(valid ? -group.y : infinity, minus_bottom);
      ViewVertex* const to = vertices.data() + patch.first_vertex + i;
      for (int lane = 0; lane < count; ++lane) {
        to[lane] = {group.x[lane], group.y[lane], {},           group.w[lane],
                    group.k[lane], group.u[lane], group.v[lane]};
      }
    }
    extents[p] = {.in_front = behind == 0,
                  .behind = in_front == 0,
                  .left = least(left),
                  .right = -least(minus_right),
                  .top = least(top),
                  .bottom = -least(minus_bottom)};
  }
}

}  // namespace copresence::renderer
