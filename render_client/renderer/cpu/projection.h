#pragma once

// From a camera's mesh to the eye's image. Private to the CPU renderer.
//
// A mesh's vertex is homogeneous, (x, y, 1, w) for the point (x, y, 1) / w, and so one 3x4 matrix M = K_eye
// [R | t] takes it to (X, Y, Z): the view's pixel is (X, Y) / Z, and 1/Z, w/Z, u/Z and v/Z are affine in the
// view's pixel over a triangle. w/Z is the inverse depth along the eye's axis; the texture coordinate is the
// ratio of two others.

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/merged_view.h"

namespace copresence::renderer {

/// Texture coordinates in a view are fixed point, in steps of 1/16 pixel.
inline constexpr int kTexelSteps = 16;

struct ViewVertex {
  float x, y;    ///< pixel of the view
  float pad[2];  ///< keeps what follows, which is interpolated, on 16 bytes
  float w;       ///< inverse depth along the eye's axis, 1/m
  float k;       ///< 1/Z
  float u, v;    ///< (kTexelSteps * pixel + 1/2) * k, so that truncation rounds to the nearest step
};
static_assert(sizeof(ViewVertex) == 32);

using ProjectionMatrix = Eigen::Matrix<float, 3, 4>;

ProjectionMatrix projection_matrix(const VirtualCamera& eye, const Rigid3& world_from_camera);

/// A homogeneous vertex after projection: what clipping interpolates.
struct ClipVertex {
  float x, y, z, w, u, v;  ///< x, y, z as (X, Y, Z); u, v the camera's pixel
  bool is_in_front(float near_m) const { return z > 0 && z >= near_m * w; }
};

ClipVertex project(const DepthMesh& mesh, std::size_t vertex, const ProjectionMatrix& matrix);

/// Requires a vertex in front.
ViewVertex to_view(const ClipVertex& vertex);

/// Where a patch lies in the view.
struct PatchExtent {
  bool in_front = true;  ///< all of it; else some vertices are too near or behind the eye, and have no place
  bool behind = true;    ///< all of it
  float left = std::numeric_limits<float>::infinity(), right = -left;  ///< of its vertices in front
  float top = std::numeric_limits<float>::infinity(), bottom = -top;
};

/// Projects the patches [begin, end). Requires room for all of the mesh in `vertices` and `extents`. Thread:
/// distinct ranges may run side by side.
void project_patches(const DepthMesh& mesh, std::size_t begin, std::size_t end,
                     const ProjectionMatrix& matrix, float near_m, std::vector<ViewVertex>& vertices,
                     std::vector<PatchExtent>& extents);

}  // namespace copresence::renderer
