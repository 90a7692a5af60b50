#include "common/window/window.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <optional>

#include "tests/support/virtual_display.h"
#include "tests/support/window_user.h"

namespace copresence::window {
namespace {

constexpr unsigned kShiftMask = 1;  // As X defines it.

class WindowGl : public testing::Test {
 protected:
  void SetUp() override {
    display_.emplace();
    if (!display_->is_there()) {
      std::cerr << "*** SKIPPED, NOT TESTED: no Xvfb here, install xvfb ***\n";
      GTEST_SKIP() << "no Xvfb";
    }
    auto opened = Window::open("the room", 320, 240, gl::Debug::kOn);
    ASSERT_TRUE(opened.has_value()) << opened.error().what;
    window_ = std::move(*opened);
    window_->set_vsync(false);
  }

  void TearDown() override {
    if (!window_) return;
    for (const std::string& error : window_->context().take_errors()) ADD_FAILURE() << "OpenGL: " << error;
  }

  // Events of one kind that come within a second, at least `count`.
  template <class Kind>
  std::vector<Kind> wait_for(std::size_t count) {
    std::vector<Kind> found;
    for (int tries = 0; tries < 20 && found.size() < count; ++tries) {
      for (const Event& event : window_->poll(std::chrono::milliseconds(50))) {
        if (const auto* kind = std::get_if<Kind>(&event)) found.push_back(*kind);
      }
    }
    return found;
  }

  Window& window() { return *window_; }

  // Shows a picture as a program does, again and again: the first ones may come before the window is on the
  // screen. Returns what is there in the end.
  template <class Picture>
  Image<Rgba8> present_until(const Picture& picture, const Image<Rgba8>& expected) {
    WindowUser person("the room");
    Image<Rgba8> seen;
    for (int tries = 0; tries < 50 && seen != expected; ++tries) {
      window_->present(picture);
      window_->poll(std::chrono::milliseconds(10));
      seen = person.see(window_->width(), window_->height());
    }
    return seen;
  }

 private:
  std::optional<VirtualDisplay> display_;  // lives longer than the window
  std::unique_ptr<Window> window_;
};

Image<Rgba8> colorful(int width, int height) {
  Image<Rgba8> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = {std::uint8_t(x), std::uint8_t(y), std::uint8_t(x * y), 255};
    }
  }
  return image;
}

TEST(Window, WithoutADisplaySaysWhatToDo) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const auto window = Window::open("the room", 320, 240);
  ASSERT_FALSE(window.has_value());
  EXPECT_EQ(window.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(window.error().what, "no display: set DISPLAY or use --headless");
}

TEST_F(WindowGl, ShowsTheSamePixels) {
  EXPECT_EQ(window().width(), 320);
  EXPECT_EQ(window().height(), 240);
  const Image<Rgba8> image = colorful(320, 240);
  EXPECT_TRUE(present_until(image, image) == image);
}

TEST_F(WindowGl, ShowsATextureOfItsContext) {
  const Image<Rgba8> image = colorful(320, 240);
  gl::Texture texture(window().context(), gl::Format::kRgba8, 320, 240);
  texture.upload(image);
  EXPECT_TRUE(present_until(texture, image) == image);
}

TEST_F(WindowGl, ScalesAndKeepsTheSidesRatio) {
  const Rgba8 orange{200, 100, 50, 255};
  Image<Rgba8> expected(320, 240, Rgba8{0, 0, 0, 255});
  for (int y = 0; y < 240; ++y) std::fill_n(expected.row(y).begin() + 40, 240, orange);
  EXPECT_TRUE(present_until(Image<Rgba8>(50, 50, orange), expected) == expected);
}

TEST_F(WindowGl, ShowsTheLastPictureAgain) {
  window().present_again();  // nothing yet
  const Image<Rgba8> image = colorful(320, 240);
  ASSERT_TRUE(present_until(image, image) == image);
  window().present_again();
  WindowUser person("the room");
  EXPECT_TRUE(person.see(320, 240) == image);
}

TEST_F(WindowGl, DrawsTheOverlayOverEachPictureAndWithoutOne) {
  gl::Texture corner(window().context(), gl::Format::kRgba8, 20, 10);
  corner.upload(Image<Rgba8>(20, 10, Rgba8{0, 200, 0, 255}));
  std::uint32_t source = 0;
  glCreateFramebuffers(1, &source);
  glNamedFramebufferTexture(source, GL_COLOR_ATTACHMENT0, corner.id(), 0);
  window().set_overlay([&](std::uint32_t target) {
    glBlitNamedFramebuffer(source, target, 0, 0, 20, 10, 0, 0, 20, 10, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  });
  const auto with_corner = [](Image<Rgba8> image) {
    for (int y = 230; y < 240; ++y) std::fill_n(image.row(y).begin(), 20, Rgba8{0, 200, 0, 255});
    return image;
  };
  WindowUser person("the room");
  const Image<Rgba8> black = with_corner(Image<Rgba8>(320, 240, Rgba8{0, 0, 0, 255}));
  Image<Rgba8> seen;
  for (int tries = 0; tries < 50 && seen != black; ++tries) {
    window().present_again();
    window().poll(std::chrono::milliseconds(10));
    seen = person.see(320, 240);
  }
  EXPECT_TRUE(seen == black);
  const Image<Rgba8> image = colorful(320, 240), expected = with_corner(image);
  EXPECT_TRUE(present_until(image, expected) == expected);
  glDeleteFramebuffers(1, &source);
}

TEST_F(WindowGl, DoesNotSpinWhereTheDisplayDoesNotWait) {
  window().set_vsync(true);
  window().present(colorful(320, 240));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 10; ++i) window().present_again();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(elapsed.count(), 0.7 * 10 / window().refresh_rate_hz());
}

TEST_F(WindowGl, FollowsANewSize) {
  WindowUser person("the room");
  person.resize(400, 200);
  const auto sizes = wait_for<ResizeEvent>(1);
  ASSERT_FALSE(sizes.empty());
  EXPECT_EQ(sizes.back().width, 400);
  EXPECT_EQ(sizes.back().height, 200);
  EXPECT_EQ(window().width(), 400);
  const Image<Rgba8> image = colorful(400, 200);
  EXPECT_TRUE(present_until(image, image) == image);
}

TEST_F(WindowGl, TellsOfDragsWheelAndKeys) {
  WindowUser person("the room");
  window().poll();
  person.move(10, 20);
  person.press(1, 10, 20, kShiftMask);
  person.move(30, 25);
  person.release(1, 30, 25);
  const auto buttons = wait_for<ButtonEvent>(2);
  ASSERT_EQ(buttons.size(), 2u);
  EXPECT_EQ(buttons[0].button, Button::kLeft);
  EXPECT_TRUE(buttons[0].pressed);
  EXPECT_TRUE(buttons[0].modifiers.shift);
  EXPECT_FALSE(buttons[1].pressed);

  person.press(3, 30, 25);
  person.move(40, 50);
  const auto moves = wait_for<MoveEvent>(1);
  ASSERT_FALSE(moves.empty());
  EXPECT_EQ(moves.back().x, 40);
  EXPECT_EQ(moves.back().y, 50);
  EXPECT_TRUE(moves.back().right);
  EXPECT_FALSE(moves.back().left);

  person.press(4, 40, 50);
  const auto scrolls = wait_for<ScrollEvent>(1);
  ASSERT_EQ(scrolls.size(), 1u);
  EXPECT_EQ(scrolls[0].y, 1);

  person.press_key("r");
  const auto keys = wait_for<KeyEvent>(2);
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].key, Key{'R'});
  EXPECT_TRUE(keys[0].pressed);
  EXPECT_FALSE(keys[1].pressed);
}

TEST_F(WindowGl, NoticesTheCloseButton) {
  EXPECT_FALSE(window().should_close());
  WindowUser person("the room");
  person.click_close();
  for (int tries = 0; tries < 20 && !window().should_close(); ++tries)
    window().poll(std::chrono::milliseconds(50));
  EXPECT_TRUE(window().should_close());
}

TEST_F(WindowGl, FillsTheScreenAndComesBack) {
  window().set_fullscreen(true);
  EXPECT_TRUE(window().is_fullscreen());
  window().set_fullscreen(false);
  EXPECT_FALSE(window().is_fullscreen());
  EXPECT_GE(window().refresh_rate_hz(), 1.0);
}

}  // namespace
}  // namespace copresence::window
