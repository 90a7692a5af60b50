#include <chrono>
#include <thread>
#include <utility>

#include "common/window/window.h"
#include "render_client/display/controls.h"
#include "render_client/display/display.h"
#include "render_client/display/overlay/overlay.h"
#include "render_client/display/window_input.h"

namespace copresence::display {
namespace {

std::vector<overlay::Row> rows_of_controls() {
  std::vector<overlay::Row> rows;
  for (const Control& control : controls()) rows.push_back({control.input, control.effect});
  return rows;
}

class WindowDisplay final : public Display {
 public:
  WindowDisplay(std::unique_ptr<window::Window> window, const Stereo& stereo)
      : window_(std::move(window)),
        overlay_(window_->context(), rows_of_controls()),
        stereo_(stereo),
        refresh_(std::chrono::duration_cast<Duration>(
            std::chrono::duration<double>(1 / window_->refresh_rate_hz()))) {
    window_->set_overlay([this](std::uint32_t framebuffer) {
      overlay_.draw(framebuffer, window_->width(), window_->height());
    });
  }

  gl::Context* context() override { return &window_->context(); }

  std::optional<NextView> wait_for_next(std::optional<Instant>,
                                        const std::function<void(Instant)>&) override {
    // Most drivers block in show() until the next refresh. This wait is for other drivers.
    std::this_thread::sleep_until(next_poll_at_);
    auto events = window_->poll();
    std::erase_if(events, [this](const window::Event& event) { return overlay_.take(event); });
    const std::vector<Command> commands = take_commands(events);
    for (const Command command : commands) obey(command);
    const Instant now = std::chrono::steady_clock::now();
    next_poll_at_ = now + refresh_ * 9 / 10;
    return NextView{now + refresh_, eyes_of(stereo_), input_.translate(events, window_->height()), commands};
  }

  void show(std::span<const renderer::MergedView> eyes) override {
    const renderer::MergedView& view = eyes.front();
    if (eyes.size() == 1 && view.texture != 0) {
      window_->present(view.texture, view.width, view.height);
    } else {
      window_->present(combine(eyes));
    }
  }

  const Image<Rgba8>& combine(std::span<const renderer::MergedView> eyes) override {
    if (eyes.size() == 1) return eyes.front().color;
    compose(stereo_.mode, eyes[0].color, eyes[1].color, combined_);
    return combined_;
  }

  void show_again() override { window_->present_again(); }
  bool is_closed() const override { return window_->should_close(); }

  void set_title(const std::string& title) override {
    if (title == title_) return;
    title_ = title;
    window_->set_title(title_);
  }

  void set_overlay(overlay::Content content) override {
    content.switches.push_back(switch_of(Command::kNextStereo, "stereo", name_of(stereo_.mode)));
    overlay_.set_content(std::move(content));
  }

 private:
  /// Returns the commands of keys and of the overlay's switches.
  std::vector<Command> take_commands(const std::vector<window::Event>& events) {
    std::vector<Command> commands;
    for (const window::Event& event : events) {
      const auto* key = std::get_if<window::KeyEvent>(&event);
      if (const auto command = key ? command_of(*key) : std::nullopt) commands.push_back(*command);
    }
    for (const int id : overlay_.take_clicks()) commands.push_back(static_cast<Command>(id));
    return commands;
  }

  /// Carries out a command that concerns the window only.
  void obey(Command command) {
    if (command == Command::kNextStereo) stereo_.mode = next(stereo_.mode);
    if (command == Command::kEnd) window_->request_close();
    if (command == Command::kFullScreen) window_->set_fullscreen(!window_->is_fullscreen());
    if (command == Command::kShowFigures) overlay_.toggle_figures();
    if (command == Command::kListKeys) overlay_.toggle_keys();
  }

  std::unique_ptr<window::Window> window_;
  overlay::Overlay overlay_;
  Stereo stereo_;
  Image<Rgba8> combined_;
  Duration refresh_;
  Instant next_poll_at_{};
  WindowInput input_;
  std::string title_;
};

}  // namespace

Result<std::unique_ptr<Display>> open_window(const std::string& title, int width, int height,
                                             const Stereo& stereo) {
  auto window = window::Window::open(title, width, height);
  if (!window) return fail(window.error());
  return std::make_unique<WindowDisplay>(std::move(*window), stereo);
}

}  // namespace copresence::display
