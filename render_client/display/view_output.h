#pragma once

// Where views come to be and where they go: the window or none, the graphics context or none, and the
// renderer that fits them.
//
// Thread: one, the render thread; with a window the main thread.

#include <memory>
#include <span>
#include <vector>

#include "common/executor.h"
#include "common/gl/context.h"
#include "common/result.h"
#include "common/window/window.h"
#include "render_client/renderer/renderer.h"
#include "render_client/settings.h"

namespace copresence::client {

class ViewOutput {
 public:
  /// `workers` must outlive this. Fails where a window was asked for and there is no display, or GL and there
  /// is none.
  static Result<ViewOutput> open(const ClientSettings& settings, Executor& workers);

  /// nullptr when headless.
  window::Window* window() { return window_.get(); }
  std::string_view renderer_name() const { return renderer_->name(); }

  /// Does ahead what a view of these cameras needs no eye for.
  void prepare(std::span<const renderer::CameraView> cameras) { renderer_->prepare(cameras); }

  /// The view as the renderer makes it; shown in the window where there is one.
  Result<void> render(std::span<const renderer::CameraView> cameras, const renderer::VirtualCamera& eye);

  /// Shows the last view again.
  void present_again();

  /// The same once more as host pixels, for a picture.
  Result<Image<Rgba8>> picture(std::span<const renderer::CameraView> cameras,
                               const renderer::VirtualCamera& eye);

 private:
  ViewOutput() = default;

  std::unique_ptr<window::Window> window_;
  std::unique_ptr<gl::Context> headless_;
  std::unique_ptr<renderer::Renderer> renderer_;
  renderer::MergedView view_;
};

}  // namespace copresence::client
