#include <chrono>
#include <thread>

#include "common/window/window.h"
#include "render_client/display/display.h"
#include "render_client/display/window_input.h"

namespace copresence::display {
namespace {

class WindowDisplay final : public Display {
 public:
  explicit WindowDisplay(std::unique_ptr<window::Window> window)
      : window_(std::move(window)),
        refresh_(std::chrono::duration_cast<Duration>(
            std::chrono::duration<double>(1 / window_->refresh_rate_hz()))) {}

  gl::Context* context() override { return &window_->context(); }

  std::optional<NextView> wait_for_next(std::optional<Instant>,
                                        const std::function<void(Instant)>&) override {
    // Most drivers block in show() until the next refresh. This wait is for other drivers.
    std::this_thread::sleep_until(next_poll_at_);
    const auto events = window_->poll();
    obey_keys(events);
    const Instant now = std::chrono::steady_clock::now();
    next_poll_at_ = now + refresh_ * 9 / 10;
    return NextView{now + refresh_, {Rigid3{}}, input_.translate(events, window_->height())};
  }

  void show(std::span<const renderer::MergedView> eyes) override {
    const renderer::MergedView& view = eyes.front();
    if (view.texture != 0) {
      window_->present(view.texture, view.width, view.height);
    } else {
      window_->present(view.color);
    }
  }

  void show_again() override { window_->present_again(); }
  bool is_closed() const override { return window_->should_close(); }

  void set_title(const std::string& title) override {
    if (title == title_) return;
    title_ = title;
    window_->set_title(title_);
  }

 private:
  /// Escape closes the window. F11 switches to full screen and back.
  void obey_keys(const std::vector<window::Event>& events) {
    for (const window::Event& event : events) {
      const auto* key = std::get_if<window::KeyEvent>(&event);
      if (!key || !key->pressed || key->repeated) continue;
      if (key->key == window::Key::kEscape) window_->request_close();
      if (key->key == window::Key::kF11) window_->set_fullscreen(!window_->is_fullscreen());
    }
  }

  std::unique_ptr<window::Window> window_;
  Duration refresh_;
  Instant next_poll_at_{};
  WindowInput input_;
  std::string title_;
};

}  // namespace

Result<std::unique_ptr<Display>> open_window(const std::string& title, int width, int height) {
  auto window = window::Window::open(title, width, height);
  if (!window) return fail(window.error());
  return std::make_unique<WindowDisplay>(std::move(*window));
}

}  // namespace copresence::display
