#include "render_client/display/view_output.h"

#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/renderer/gl/gl_renderer.h"

namespace copresence::client {

Result<ViewOutput> ViewOutput::open(const ClientSettings& settings, Executor& workers) {
  ViewOutput output;
  gl::Context* context = nullptr;
  if (!settings.headless) {
    auto window = window::Window::open("Copresence", settings.width, settings.height);
    if (!window) return fail(window.error());
    output.window_ = std::move(*window);
    context = &output.window_->context();
  } else if (settings.renderer == "gl" || (settings.renderer == "auto" && gl::has_graphics_card())) {
    auto headless = gl::Context::headless();
    if (!headless && settings.renderer == "gl") return fail(headless.error());
    if (headless) {
      output.headless_ = std::move(*headless);
      context = output.headless_.get();
    }
  }
  const bool use_gl =
      settings.renderer == "gl" || (settings.renderer == "auto" && context && !context->is_software());
  if (!use_gl) {
    output.headless_.reset();
    output.renderer_ = renderer::make_cpu_renderer(workers);
    return output;
  }
  auto made = renderer::make_gl_renderer(*context);
  if (!made) return fail(made.error());
  output.renderer_ = std::move(*made);
  return output;
}

Result<void> ViewOutput::render(std::span<const renderer::CameraView> cameras,
                                const renderer::VirtualCamera& eye) {
  // The CPU renderer's picture is host pixels in any case; the GL renderer's stays on the graphics card.
  const bool in_gl = renderer_->name() == "gl";
  if (auto rendered = renderer_->render(cameras, eye, {.color = !in_gl}, view_); !rendered) return rendered;
  if (window_ && in_gl) window_->present(view_.texture, view_.width, view_.height);
  if (window_ && !in_gl) window_->present(view_.color);
  return {};
}

void ViewOutput::present_again() {
  if (window_) window_->present_again();
}

Result<Image<Rgba8>> ViewOutput::picture(std::span<const renderer::CameraView> cameras,
                                         const renderer::VirtualCamera& eye) {
  renderer::MergedView view;
  if (auto rendered = renderer_->render(cameras, eye, {.color = true}, view); !rendered)
    return fail(rendered.error());
  return std::move(view.color);
}

}  // namespace copresence::client
