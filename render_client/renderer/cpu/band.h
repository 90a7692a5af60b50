#pragma once

// One camera's surface as the eye sees it, for a band of the view's rows small enough to stay in the cache.
// Private to the CPU renderer. Thread: a value.

#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/projection.h"

namespace copresence::renderer {

/// w, k, u, v of a ViewVertex.
using Attributes = float __attribute__((vector_size(16)));

/// Fragments of one camera in the rows [top, top + rows) of a view.
class Band {
 public:
  /// Empties the band, for fragments of a camera with images of `camera_width` x `camera_height` pixels.
  /// Nothing farther than `far_m` will be drawn. Keeps its memory where it can.
  void begin(int width, int top, int rows, float far_m, int camera_width, int camera_height);

  /// Draws what of a triangle lies in the band, where it is nearer than what is there. Clockwise triangles
  /// only: the others show their back. A pixel is covered when its centre is inside or up to 1/64 pixel
  /// outside, so that adjoining triangles leave no cracks.
  void draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c);

  /// The triangles (a, b, d) and (b, c, d). Where they make a convex quad it is drawn as one plane, which
  /// passes each corner at a quarter of what the four are off a common plane: far below the sensor's noise
  /// (DepthMesh joins and flattens only what is), at half the cost.
  void draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c, const ViewVertex& d);

  /// Removes what is drawn where `live` has anything. Requires a band of the same rows.
  void give_way_to(const Band& live);

  int width() const { return width_; }
  int top() const { return top_; }
  int rows() const { return rows_; }

  /// Inverse depth, at most empty() where there is nothing. Rows of the view, whole groups of kLanes.
  const float* depths(int y) const { return w_.data() + offset(y); }
  /// v << 16 | u in 1/kTexelSteps pixels of the camera, inside its image; undefined where there is nothing.
  const std::uint32_t* texels(int y) const { return texel_.data() + offset(y); }
  float empty() const { return empty_; }

 private:
  struct Box {
    int left, top, right, bottom;  // pixels, inclusive
  };
  template <int kEdges>
  class Polygon;
  struct AttributePlane;
  bool find_box(const Attributes& least, const Attributes& most, Box& box) const;
  template <int kEdges>
  void fill(const Box& box, const Polygon<kEdges>& outline, const AttributePlane& plane);
  template <class Row>
  [[gnu::always_inline]] inline void keep(const Floats& inside, const AttributePlane& plane, const Row& row,
                                          const Floats& across, float* depths, std::uint32_t* texels,
                                          std::ptrdiff_t second_half) const;
  std::size_t offset(int y) const { return static_cast<std::size_t>(y - top_) * row_; }

  int width_ = 0, top_ = 0, rows_ = 0;
  int row_ = 0;  // width and room for a group that begins at its last pixel; and one row more than rows_
  float empty_ = 0;
  float last_u_ = 0, last_v_ = 0;
  std::vector<float> w_;
  std::vector<std::uint32_t> texel_;
};

/// Draws a patch of a mesh into a band; clips what crosses the near plane.
void draw_patch(const DepthMesh& mesh, const DepthMesh::Patch& patch, const PatchExtent& extent,
                const std::vector<ViewVertex>& vertices, const ProjectionMatrix& matrix, float near_m,
                Band& band);

}  // namespace copresence::renderer
