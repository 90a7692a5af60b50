#include "render_client/renderer/projection.h"

#include <algorithm>

namespace copresence::renderer {

ProjectionMatrix projection_matrix(const VirtualCamera& eye, const Rigid3& world_from_camera) {
  const Rigid3 eye_from_camera = eye.world_from_eye.inverse() * world_from_camera;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = eye.lens.fx;
  K(1, 1) = eye.lens.fy;
  K(0, 2) = eye.lens.cx;
  K(1, 2) = eye.lens.cy;
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

void project_patches(const DepthMesh& mesh, std::size_t begin, std::size_t end,
                     const ProjectionMatrix& matrix, float near_m, std::vector<ViewVertex>& vertices,
                     std::vector<PatchExtent>& extents) {
  for (std::size_t p = begin; p < end; ++p) {
    const DepthMesh::Patch& patch = mesh.patches[p];
    PatchExtent extent;
    for (std::size_t i = patch.first_vertex; i < patch.first_vertex + patch.vertices; ++i) {
      const ClipVertex projected = project(mesh, i, matrix);
      if (!projected.is_in_front(near_m)) {
        extent.in_front = false;
        continue;
      }
      extent.behind = false;
      const ViewVertex vertex = to_view(projected);
      vertices[i] = vertex;
      extent.left = std::min(extent.left, vertex.x);
      extent.right = std::max(extent.right, vertex.x);
      extent.top = std::min(extent.top, vertex.y);
      extent.bottom = std::max(extent.bottom, vertex.y);
    }
    extents[p] = extent;
  }
}

}  // namespace copresence::renderer
