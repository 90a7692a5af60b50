#pragma once

// Makes the surface of a camera's frame: its mesh and the texture on it (merge_rules.h). The
// surface does not depend on the eye, so it is made once per frame. The CPU renderer draws it
// itself. The browser's viewer page gets it from here, too, and draws it with WebGL (web/). Thread:
// different objects may be used at the same time.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "render_client/renderer/cpu/block_stitching.h"
#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/depth_mesh.h"
#include "render_client/renderer/cpu/planar_blocks.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

class CameraSurface {
 public:
  /// Planar regions become blocks of up to this many pixels a side: 1, 4, 8 or 16.
  explicit CameraSurface(int largest_block) : largest_block_(largest_block) {}

  /// Makes the surface again if the frame's version, or anything else that it depends on, differs
  /// from the last call.
  void update(const CameraView& camera);

  const DepthMesh& mesh() const { return mesh_; }
  const CameraTexture& texture() const { return texture_; }
  /// The inverse depths of the frame, after BlockStitching.
  const InverseDepth& inverse() const { return inverse_; }

 private:
  void make_mesh(const CameraView& camera);

  int largest_block_;
  bool has_frame_ = false;
  std::uint64_t version_ = 0;
  CameraModel model_;
  DepthUnit unit_ = DepthUnit::kMillimetre;
  DepthNoise noise_;
  Eigen::Matrix<float, 3, 4> color_correction_;
  std::vector<Eigen::Vector2f> rays_, straightened_rays_;
  InverseDepth inverse_;
  PlanarBlocks planar_;
  MeshBlocks blocks_;
  BlockStitching stitching_;
  Image<float> incidences_;
  DepthMesh mesh_;
  CameraTexture texture_;
};

}  // namespace copresence::renderer
