#pragma once

// Projects a camera's mesh into the view.
//
// A vertex of a mesh is homogeneous: (x, y, 1, w) for the point (x, y, 1) / w. One 3x4 matrix M =
// K_eye [R | t] takes it to (X, Y, Z). The view's pixel is (X, Y) / Z. Over a triangle 1/Z, w/Z,
// u/Z and v/Z are affine functions of the view's pixel. w/Z is the inverse depth along the eye's
// axis. The texture coordinate is (u/Z) / (1/Z), and likewise for v.

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// Texture coordinates in a view are fixed point, in steps of 1/16 pixel.
inline constexpr int kTexelSteps = 16;

struct ViewVertex {
  float x, y;    ///< pixel of the view
  float pad[2];  ///< aligns the interpolated members below to 16 bytes
  float w;       ///< inverse depth along the eye's axis, 1/m
  float k;       ///< 1/Z
  float u, v;    ///< (kTexelSteps * pixel + 1/2) * k, so that truncation rounds to the nearest step
};
static_assert(sizeof(ViewVertex) == 32);

using ProjectionMatrix = Eigen::Matrix<float, 3, 4>;

ProjectionMatrix projection_matrix(const ViewPose& eye, const Rigid3& world_from_camera);

/// A homogeneous vertex after projection. Clipping interpolates it.
struct ClipVertex {
  float x, y, z, w, u, v;  ///< x, y, z are (X, Y, Z); u, v are the camera's pixel
  bool is_in_front(float near_m) const { return z > 0 && z >= near_m * w; }
};

ClipVertex project(const DepthMesh& mesh, std::size_t vertex, const ProjectionMatrix& matrix);

/// Requires a vertex in front of the near plane.
ViewVertex to_view(const ClipVertex& vertex);

/// The bounds of a patch in the view.
struct PatchExtent {
  /// The whole patch is in front of the near plane. Else some vertices have no position in the
  /// view.
  bool in_front = true;
  bool behind = true;  ///< the whole patch is behind the near plane
  float left = std::numeric_limits<float>::infinity(), right = -left;  ///< of its vertices in front
  float top = std::numeric_limits<float>::infinity(), bottom = -top;
};

/// Projects the patches [begin, end). Requires that `vertices` and `extents` have the size of the
/// whole mesh. Thread: distinct ranges may be projected at the same time.
void project_patches(const DepthMesh& mesh, std::size_t begin, std::size_t end,
                     const ProjectionMatrix& matrix, float near_m, std::vector<ViewVertex>& vertices,
                     std::vector<PatchExtent>& extents);

}  // namespace copresence::renderer
