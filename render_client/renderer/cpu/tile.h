#pragma once

// Draws one camera's surface, as seen from the eye, into a tile. A tile is a few rows of the view,
// few enough to stay in the cache. Thread: different tiles may be drawn at the same time.

#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/projection.h"

namespace copresence::renderer {

/// The members w, k, u and v of a ViewVertex.
using Attributes = float __attribute__((vector_size(16)));

/// The fragments of one camera in the rows [top, top + rows) of a view.
class Tile {
 public:
  /// Empties the tile and sets its size in pixels. `camera_width` and `camera_height` are the size
  /// of the camera's images. Fragments farther than `far_m` are not drawn.
  void begin(int width, int top, int rows, float far_m, int camera_width, int camera_height);

  /// Draws the part of a triangle that lies in the tile and is nearer than earlier fragments. Back
  /// faces, which are anticlockwise, are not drawn. A pixel is covered if its centre lies inside
  /// the triangle, or up to 1/64 pixel outside. So adjoining triangles leave no cracks.
  void draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c);

  /// Draws the triangles (a, b, d) and (b, c, d). If they form a convex quad, a single plane is
  /// drawn instead, at half the cost. The plane minimises the distances from the four corners.
  /// These are far below the sensor's noise, since DepthMesh connects only points of one surface.
  void draw(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c, const ViewVertex& d);

  /// Removes the fragments of pixels that have one in `other`. Requires a tile of the same rows.
  void give_way_to(const Tile& other);

  int width() const { return width_; }
  int top() const { return top_; }
  int rows() const { return rows_; }
  /// Only the columns [left(), right()) may have fragments.
  int left() const { return left_; }
  int right() const { return right_; }

  /// Inverse depths of row y of the view, padded to whole groups of kLanes. A value of at most
  /// empty() means that there is no fragment.
  const float* depths(int y) const { return w_.data() + offset(y); }
  /// Texture coordinates v << 16 | u of row y, in steps of 1/kTexelSteps pixel. They lie inside the
  /// camera's image. They are undefined where there is no fragment.
  const std::uint32_t* texels(int y) const { return texel_.data() + offset(y); }
  float empty() const { return empty_; }

 private:
  struct Box {
    int left, top, right, bottom;  // In pixels, both ends included.
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
  int row_ = 0;  // Elements per row, with room for a group of kLanes that begins at the last pixel.
  int left_ = 0, right_ = 0;
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
