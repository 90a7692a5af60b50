#include <chrono>

#include "render_client/display/display.h"

namespace copresence::display {
namespace {

/// The longest wait for frames. It is short, because the caller has other work to do as well.
constexpr std::chrono::milliseconds kLongestWait{100};

class HeadlessDisplay final : public Display {
 public:
  HeadlessDisplay(std::unique_ptr<gl::Context> context, const Stereo& stereo)
      : context_(std::move(context)), stereo_(stereo) {}

  gl::Context* context() override { return context_.get(); }

  std::optional<NextView> wait_for_next(std::optional<Instant> wanted,
                                        const std::function<void(Instant)>& wait) override {
    const Instant now = std::chrono::steady_clock::now();
    if (wanted && *wanted <= now) return NextView{.display_time = now, .eyes = eyes_of(stereo_)};
    wait(wanted.value_or(now + kLongestWait));
    return std::nullopt;
  }

  void show(std::span<const renderer::MergedView>) override {}
  void show_again() override {}

  const Image<Rgba8>& combine(std::span<const renderer::MergedView> eyes) override {
    if (eyes.size() == 1) return eyes.front().color;
    compose(stereo_.mode, eyes[0].color, eyes[1].color, combined_);
    return combined_;
  }

  bool is_closed() const override { return false; }
  void set_title(const std::string&) override {}
  void set_overlay(overlay::Content) override {}

 private:
  std::unique_ptr<gl::Context> context_;
  Stereo stereo_;
  Image<Rgba8> combined_;
};

}  // namespace

Result<std::unique_ptr<Display>> open_headless(HeadlessGl gl, const Stereo& stereo) {
  std::unique_ptr<gl::Context> context;
  if (gl == HeadlessGl::kYes || (gl == HeadlessGl::kOnGraphicsCard && gl::has_graphics_card())) {
    auto made = gl::Context::headless();
    if (!made && gl == HeadlessGl::kYes) return fail(made.error());
    if (made && (gl == HeadlessGl::kYes || !(*made)->is_software())) context = std::move(*made);
  }
  return std::make_unique<HeadlessDisplay>(std::move(context), stereo);
}

}  // namespace copresence::display
