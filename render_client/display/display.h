#pragma once

// Where views are shown, and when the next one is due. Headless and a window today.
//
// Thread: one thread; for a window the main thread.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/frame/rigid3.h"
#include "common/gl/context.h"
#include "common/result.h"
#include "render_client/renderer/renderer.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::display {

/// The next view to draw.
struct NextView {
  Instant display_time;                      ///< when the view will be visible
  std::vector<Rigid3> head_from_eyes;        ///< one picture is drawn for each eye; metres
  std::vector<viewpoint::Gesture> gestures;  ///< of the person, since the last view
};

class Display {
 public:
  virtual ~Display() = default;

  /// The context that views are drawn in. Null if they are host pixels and the display has no
  /// OpenGL.
  virtual gl::Context* context() = 0;

  /// Waits until a view is due. Returns nothing if none is due yet: call it again after looking for
  /// new frames. A window wants a view at every refresh. Headless, a view is due at `wanted`, the
  /// time at which the cameras' frames ask for one. `wait` waits for new frames until an instant at
  /// most.
  virtual std::optional<NextView> wait_for_next(std::optional<Instant> wanted,
                                                const std::function<void(Instant)>& wait) = 0;

  /// Shows the pictures of all eyes: textures of context(), or host pixels where a picture has no
  /// texture.
  virtual void show(std::span<const renderer::MergedView> eyes) = 0;

  /// Shows the last view again. Requires that its textures still exist.
  virtual void show_again() = 0;

  /// Whether the person has closed it.
  virtual bool is_closed() const = 0;

  virtual void set_title(const std::string& title) = 0;
};

/// Fails with kUnavailable without a display, and with kUnsupported without OpenGL 4.5.
Result<std::unique_ptr<Display>> open_window(const std::string& title, int width, int height);

/// Whether a headless display has an OpenGL context.
enum class HeadlessGl {
  kNo,
  kOnGraphicsCard,  ///< only if a graphics card draws
  kYes,
};
/// Fails only for kYes, if there is no OpenGL.
Result<std::unique_ptr<Display>> open_headless(HeadlessGl gl);

}  // namespace copresence::display
