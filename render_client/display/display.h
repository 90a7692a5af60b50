#pragma once

// Shows views and decides when the next view is due. There are two displays: a window, and a
// headless display that shows nothing. Thread: one thread; for a window, the main thread.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/frame/rgbd_frame.h"
#include "common/gl/context.h"
#include "common/result.h"
#include "render_client/display/controls.h"
#include "render_client/display/overlay/overlay.h"
#include "render_client/display/stereo.h"
#include "render_client/renderer/renderer.h"
#include "render_client/viewpoint/eye.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::display {

struct NextView {
  Instant display_time;                        ///< Time at which the view will be visible.
  std::vector<viewpoint::Eye> eyes;            ///< Each eye gets a picture.
  std::vector<viewpoint::Gesture> gestures{};  ///< The user's gestures since the last view.
  std::vector<Command> commands{};             ///< The user's commands since the last view.
};

class Display {
 public:
  virtual ~Display() = default;

  /// Returns the context for drawing views, or null if the display has no OpenGL.
  virtual gl::Context* context() = 0;

  /// Waits until a view is due. If it returns nothing, no view is due yet: check for new frames and
  /// call it again. In a window, a view is due at every refresh of the screen. Without a window, a
  /// view is due at `wanted`, a time that follows from the cameras' frames. `wait` is a function
  /// that waits for new frames until the given instant.
  virtual std::optional<NextView> wait_for_next(std::optional<Instant> wanted,
                                                const std::function<void(Instant)>& wait) = 0;

  /// Shows the pictures of all eyes. Several pictures must be host pixels. A single one may also be a
  /// texture of context().
  virtual void show(std::span<const renderer::MergedView> eyes) = 0;

  /// Shows the last view again. Requires that its textures still exist.
  virtual void show_again() = 0;

  virtual bool is_closed() const = 0;

  virtual void set_title(const std::string& title) = 0;

  /// Combines the host pixels of all eyes to the picture that the display shows. The result is valid
  /// until the next call.
  virtual const Image<Rgba8>& combine(std::span<const renderer::MergedView> eyes) = 0;

  /// Sets what the window shows over the view from now on.
  virtual void set_overlay(overlay::Content content) = 0;
};

/// Opens a window. Fails with kUnavailable without a screen, kUnsupported without OpenGL 4.5.
Result<std::unique_ptr<Display>> open_window(const std::string& title, int width, int height,
                                             const Stereo& stereo);

/// Selects whether a headless display has an OpenGL context.
enum class HeadlessGl {
  kNo,
  kOnGraphicsCard,  ///< Only if OpenGL runs on a graphics card.
  kYes,
};
/// Makes a headless display. Fails only for kYes, if OpenGL is missing.
Result<std::unique_ptr<Display>> open_headless(HeadlessGl gl, const Stereo& stereo);

}  // namespace copresence::display
