#pragma once

// Extends the farther surfaces into the parts of a view that no camera has seen
// (extension_rules.h). Thread: one thread at a time, except for survey(). The result does not depend
// on the number of workers.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/executor.h"
#include "common/frame/image.h"
#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/picture_colors.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// Inverse depth along the eye's axis, 1/m; 0 where no camera shows anything.
using InverseDepthView = Image<float>;

class BackgroundExtension {
 public:
  /// Prepares a view of this size in pixels.
  void begin(int width, int height);

  /// Looks for gaps in the rows [top, top + rows) of the view. Requires that `top` is a multiple of
  /// kExtensionBlock, and so is `rows` unless they end at the view's last row. Different threads may
  /// survey different rows.
  void survey(const InverseDepthView& seen, int top, int rows);

  /// Fills colour, depth and origin of the empty pixels of `view`. Returns the number of pixels
  /// filled. Requires that all rows have been surveyed, and that `seen` and the colour have the
  /// view's size. Depth and origin are skipped if their images are empty. `pictures[i]` belongs to
  /// `cameras[i]`.
  std::size_t apply(const ViewPose& eye, std::span<const CameraView> cameras,
                    std::span<const CameraPictures> pictures, const InverseDepthView& seen,
                    const UnseenStyle& style, Executor& workers, MergedView& view);

 private:
  struct Block {
    float w = 0;  // 0 without a surface.
    float r = 0, g = 0, b = 0;
    float opacity = 1;
    bool may_be_pictured = false;  ///< Whether a camera's picture may show an extended surface here.
  };
  struct Source {
    std::int32_t block = -1;    // Index of the block; -1 without a source.
    std::int32_t distance = 0;  // Distance in blocks along the direction.
    float slope = 0;            // Change of w per block towards the gap.
  };

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  /// Sums up blocks with weights.
  struct Mean {
    float w = 0, r = 0, g = 0, b = 0, weight = 0;

    template <class Surface>
    void add(const Surface& surface, float share) {
      w += share * surface.w;
      r += share * surface.r;
      g += share * surface.g;
      b += share * surface.b;
      weight += share;
    }
    template <class Surface>
    void store(Surface& surface) const {
      const float scale = 1 / weight;
      surface.w = w * scale;
      surface.r = r * scale;
      surface.g = g * scale;
      surface.b = b * scale;
    }
  };
  /// The surfaces left and right of a pixel.
  struct Surfaces {
    std::array<Mean, 2> sides;
    std::array<float, 2> opacities{0, 0};  // Summed with the weights of `sides`.
  };

  void list_gaps();
  void find_farthest(const InverseDepthView& seen, int block_x, int block_y);
  std::vector<std::int32_t> near_gaps() const;
  void average_farthest(const InverseDepthView& seen, const Image<Rgba8>& color, std::int32_t block);
  void find_sources(int dx, int dy, std::vector<Source>& sources) const;
  Source source_at(int x, int y, int dx, int dy) const;
  Block estimate(std::size_t block) const;
  Block smoothed(std::int32_t block) const;
  /// A camera's picture. It serves to test whether a point of the view lies in the picture.
  struct Picture {
    Eigen::Matrix3f rotation;  // Camera from eye.
    Eigen::Vector3f translation;
    float fx, fy, cx, cy, right, bottom, per_fade;
  };
  void list_pictures(const ViewPose& eye, std::span<const CameraView> cameras);
  void find_visibility(const ViewPose& eye, std::int32_t block);
  float opacity_at(const ViewPose& eye, int x, int y, float w) const;
  Surfaces surfaces_between(int left, int top, float down) const;
  std::size_t fill_pixels(int x, int y, int columns, const Ints& empty, const Floats& right,
                          const Surfaces& surfaces, bool may_be_pictured, const UnseenStyle& style,
                          MergedView& view) const;
  std::size_t fill_row(int y, const InverseDepthView& seen, const UnseenStyle& style, MergedView& view) const;

  int width_ = 0, height_ = 0;  // In blocks.
  std::vector<Picture> pictures_;
  PictureColors colors_;
  std::vector<Block> blocks_;
  std::vector<Block> estimates_, smoothed_;  // Valid for gaps and the blocks around them.
  std::vector<std::uint8_t> is_gap_;         // By block.
  std::vector<std::int32_t> gaps_;           // Indices of the blocks that are gaps.
  std::array<std::vector<Source>, 8> sources_;
  std::vector<std::size_t> filled_;  // Number of filled pixels by row of blocks.
};

}  // namespace copresence::renderer
