#pragma once

// One camera's surface as seen from the eye, for a tile: a few rows of the view, small enough to
// stay in the cache.
//
// Thread: a value.

#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/projection.h"

namespace copresence::renderer {

/// w, k, u, v of a ViewVertex.
using Attributes = float __attribute__((vector_size(16)));

/// Fragments of one camera in the rows [top, top + rows) of a view.
class Tile {
 public:
  /// Empties the tile. `camera_width` and `camera_height` are the size of the camera's images, in
  /// pixels. Nothing farther than `far_m` will be drawn. Keeps its memory where it can.
  void begin(int width, int top, int rows, float far_m, int camera_width, int camera_height);

  /// Draws the part of a triangle that lies in the tile and is nearer than earlier fragments. Only
  /// clockwise triangles are drawn, since others show their back. A pixel is covered if its centre
  /// lies inside the triangle, or up to 1/64 pixel outside. So adjoining triangles leave no cracks.
  void draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c);

  /// Draws the triangles (a, b, d) and (b, c, d). If they make a convex quad, one plane is drawn
  /// instead, at half the cost. Its distance from each corner is a quarter of the corners'
  /// deviation from a common plane. That is far below the sensor's noise, since DepthMesh connects
  /// only points of one surface.
  void draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c, const ViewVertex& d);

  /// Removes fragments at pixels where `live` has any. Requires a tile of the same rows.
  void give_way_to(const Tile& live);

  int width() const { return width_; }
  int top() const { return top_; }
  int rows() const { return rows_; }

  /// Inverse depths of row y of the view, in whole groups of kLanes. At most empty() where there is
  /// no fragment.
  const float* depths(int y) const { return w_.data() + offset(y); }
  /// v << 16 | u in 1/kTexelSteps pixels of the camera, inside its image. Undefined where there is
  /// no fragment.
  const std::uint32_t* texels(int y) const { return texel_.data() + offset(y); }
  float empty() const { return empty_; }

 private:
  struct Box {
    int left, top, right, bottom;  // pixels, both ends included
  };
  template <int kEdges>
  class Polygon;
  struct AttributePlane;
  bool find_box(const Attributes& least, const Attributes& most, Box& box) const;
  template <int kEdges>
  void fill(const Box& box, const Polygon<kEdges>& polygon, const AttributePlane& plane);
  template <class Row>
  [[gnu::always_inline]] inline void keep(const Floats& inside, const AttributePlane& plane, const Row& row,
                                          const Floats& across, float* depths, std::uint32_t* texels,
                                          std::ptrdiff_t second_half) const;
  std::size_t offset(int y) const { return static_cast<std::size_t>(y - top_) * row_; }

  int width_ = 0, top_ = 0, rows_ = 0;
  int row_ = 0;  // elements per row: the width, and room for a group that begins at the last pixel
  float empty_ = 0;
  float last_u_ = 0, last_v_ = 0;
  std::vector<float> w_;
  std::vector<std::uint32_t> texel_;
};

/// Draws a patch of a mesh into a tile. Clips triangles that cross the near plane.
void draw_patch(const DepthMesh& mesh, const DepthMesh::Patch& patch, const PatchExtent& extent,
                const std::vector<ViewVertex>& vertices, const ProjectionMatrix& matrix, float near_m,
                Tile& tile);

}  // namespace copresence::renderer
