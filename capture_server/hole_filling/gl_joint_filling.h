#pragma once

// Joint filling on a graphics card, as compute shaders. The steps are those of JointFilling; a test
// compares the two. The cells with holes to fill are gathered in a list. Later shaders run over
// that list by indirect dispatch.
//
// Thread: that of the context.

#include <memory>

#include "capture_server/hole_filling/hole_filler.h"
#include "common/gl/buffer.h"
#include "common/gl/context.h"
#include "common/gl/program.h"
#include "common/gl/texture.h"

namespace copresence::hole_filling {

class GlJointFilling final : public HoleFiller {
 public:
  /// `context` must outlive the filler. Fails (kInvalid) if the driver rejects a shader.
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
  Eigen::Vector2i grid_;   // columns and rows of cells
  Eigen::Vector2f range_;  // units
  Programs programs_;
  gl::Texture depth_, color_, fillable_, filled_;
  gl::Buffer commands_, wanted_, measured_cells_, cells_, guesses_;
  DepthImage filled_host_;
};

/// A GlJointFilling with a headless context of its own. Fails (kUnavailable) without OpenGL; with
/// `hardware_only` also (kUnsupported) if OpenGL is a software renderer.
Result<std::unique_ptr<HoleFiller>> open_gl_joint_filling(const FrameFormat& format, bool hardware_only);

}  // namespace copresence::hole_filling
