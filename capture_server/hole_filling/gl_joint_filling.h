#pragma once

// Joint filling on a graphics card, as compute shaders. The processing steps are those of
// JointFilling, and a test compares the results. The first shaders gather the cells with fillable
// holes in a list. The later shaders run over that list by indirect dispatch.
// Thread: only the thread to which the context belongs.

#include <memory>

#include "capture_server/hole_filling/hole_filler.h"
#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/program.h"
#include "common/gl/texture.h"

namespace copresence::hole_filling {

class GlJointFilling final : public HoleFiller {
 public:
  /// `context` must outlive the filler. Fails with kInvalid if the driver rejects a shader.
  static Result<std::unique_ptr<GlJointFilling>> open(gl::Context& context, const FrameFormat& format);

  std::string_view name() const override { return "gl"; }
  bool is_free_of_threads() const override { return false; }
  Result<void> fill(RgbdFrame& frame) override;

 private:
  struct Programs {
    gl::Program find_fillable, see_cells, find_slopes, guess, fill;
  };

  GlJointFilling(gl::Context& context, const FrameFormat& format, Programs programs);
  static Result<Programs> compile(gl::Context& context, const FrameFormat& format);
  void upload(const RgbdFrame& frame);
  void run(bool has_color);

  gl::Context& context_;
  Eigen::Vector2i grid_;   // Columns and rows of cells.
  Eigen::Vector2f range_;  // Depth range in units.
  Programs programs_;
  gl::Texture depth_, color_, fillable_, filled_;
  gl::Buffer commands_, wanted_, measured_cells_, cells_, guesses_;
  DepthImage filled_host_;
};

/// Opens a GlJointFilling with a headless context of its own. Fails with kUnavailable without
/// OpenGL. With `hardware_only`, it also fails with kUnsupported if OpenGL is a software renderer.
Result<std::unique_ptr<HoleFiller>> open_gl_joint_filling(const FrameFormat& format, bool hardware_only);

}  // namespace copresence::hole_filling
