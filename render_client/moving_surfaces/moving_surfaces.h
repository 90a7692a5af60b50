#pragma once

// Shows what moves from one camera only.
//
// Cameras take their pictures at different instants, up to half a frame period apart. If their
// frames were merged like those of still surfaces, a waving hand would appear twice. So of two
// cameras that see a moving surface, the better one shows it. The better camera is nearer, relative
// to its noise. The other camera leaves out the pixels that the better one sees or sees past. What
// the better camera does not see stays, so nothing is lost.
//
// Moving      A pixel moves if its block does (motion_detector.h).
// Past        The better camera sees past a pixel if it measures a farther surface in that direction
//             and around it. The distance exceeds the uncertainty range (renderer/merge_rules.h).
// Sees        The better camera sees a pixel if both lie on one surface, and this surface moves in
//             its picture, too. Still surfaces beside a moving one are merged as usual.
// Better      Two cameras keep their order until the other one is kSwitch times as good, as a mean
//             over the moving pixels that both see. If a camera is kClearlyBetter times as good at
//             one pixel, it shows that pixel whatever their order is.
//
// The decision is made once for each new frame, from the newest shown frames of the others. A
// pixel that another camera has left out justifies nothing. So no two cameras leave out the same
// surface.
//
// Thread: one thread at a time.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/moving_surfaces/motion_detector.h"
#include "render_client/renderer/renderer.h"

namespace copresence::moving_surfaces {

/// Returns whether two cameras capture at nearly the same instants, every `period_s` seconds. The
/// arguments are the instants of any two of their frames. Such cameras show moving surfaces at the
/// same place. Their frames are merged like those of still surfaces, which has less noise.
bool capture_together(Instant one, Instant other, double period_s);

/// The newest frame of a camera.
struct CameraMotion {
  renderer::CameraView view;  ///< The frame may lack pixels that were left out.
  const MovingBlocks* moving = nullptr;
};

class MovingSurfaces {
 public:
  static constexpr float kSwitch = 1.3F;
  static constexpr float kClearlyBetter = 2;

  explicit MovingSurfaces(std::size_t cameras);

  /// Leaves out the pixels of a new frame that another camera shows better. Such a pixel loses its
  /// depth, but keeps its state (renderer/renderer.h, Left out). `frame` is that of
  /// cameras[camera]. An element is empty if its camera shows nothing, or nothing recent.
  void leave_out(RgbdFrame& frame, std::size_t camera, std::span<const std::optional<CameraMotion>> cameras);

 private:
  /// What becomes of a moving pixel, from the weakest to the strongest.
  enum class Verdict : std::uint8_t {
    kKeep,
    kShare,  ///< The pixel is drawn with the weight of a filled one.
    kSame,   ///< Another camera sees the same surface. The pixel is left out.
    kPast,   ///< Another camera sees past the pixel. It is left out.
  };

  float compare(const CameraMotion& own, std::span<const Eigen::Vector2f> rays, const CameraMotion& other,
                bool prefers_other);
  void apply(RgbdFrame& frame, const CameraMotion& own);

  struct Rays {
    CameraModel model;
    std::vector<Eigen::Vector2f> by_pixel;
  };

  std::size_t cameras_;
  std::vector<bool> prefers_lower_;  // By pair of cameras: whether the lower index is better.
  std::vector<Rays> rays_;           // By camera.
  Image<Verdict> verdicts_;
};

}  // namespace copresence::moving_surfaces
