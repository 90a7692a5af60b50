#pragma once

// Projects a camera's mesh into the view.
//
// The point (x, y, 1) / w is a mesh vertex with the homogeneous coordinates (x, y, 1, w). The 3x4
// matrix M = K_eye [R | t] maps it to (X, Y, Z). K_eye is the eye's pinhole matrix, and R and t are
// the pose of the camera in the eye's frame. The pixel in the view is (X, Y) / Z. w/Z is the
// inverse depth along the eye's axis. Within a triangle, 1/Z, w/Z, u/Z and v/Z are affine functions
// of the pixel's position in the view. The texture coordinates are u = (u/Z) / (1/Z) and
// v = (v/Z) / (1/Z).

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// Texture coordinates in a view are fixed-point numbers in steps of 1/16 pixel.
inline constexpr int kTexelSteps = 16;

struct ViewVertex {
  float x, y;    ///< Pixel of the view.
  float pad[2];  ///< Aligns the interpolated members below to 16 bytes.
  float w;       ///< Inverse depth along the eye's axis, 1/m.
  float k;       ///< The reciprocal 1/Z.
  /// The value (kTexelSteps * c + 1/2) / Z, where c is the coordinate in the camera's picture in
  /// pixels. Because of the added 1/2, a later truncation rounds to the nearest step.
  float u, v;
};
static_assert(sizeof(ViewVertex) == 32);

using ProjectionMatrix = Eigen::Matrix<float, 3, 4>;

ProjectionMatrix projection_matrix(const ViewPose& eye, const Rigid3& world_from_camera);

/// A homogeneous vertex after projection. Clipping interpolates it.
struct ClipVertex {
  float x, y, z, w, u, v;  ///< (x, y, z) is (X, Y, Z). (u, v) is the camera's pixel.
  bool is_in_front(float near_m) const { return z > 0 && z >= near_m * w; }
};

ClipVertex project(const DepthMesh& mesh, std::size_t vertex, const ProjectionMatrix& matrix);

/// Projects a vertex into the view. Requires a vertex in front of the near plane.
ViewVertex to_view(const ClipVertex& vertex);

/// The bounds of a patch in the view.
struct PatchExtent {
  /// Whether the whole patch is in front of the near plane. If not, some vertices have no pixel.
  bool in_front = true;
  bool behind = true;  ///< Whether the whole patch is behind the near plane.
  // The bounds of the vertices that are in front.
  float left = std::numeric_limits<float>::infinity(), right = -left;
  float top = std::numeric_limits<float>::infinity(), bottom = -top;
};

/// Projects the patches [begin, end). Requires one element of `vertices` and `extents` for each
/// vertex and patch of the whole mesh. Thread: distinct ranges may be projected at the same time.
void project_patches(const DepthMesh& mesh, std::size_t begin, std::size_t end,
                     const ProjectionMatrix& matrix, float near_m, std::vector<ViewVertex>& vertices,
                     std::vector<PatchExtent>& extents);

}  // namespace copresence::renderer
