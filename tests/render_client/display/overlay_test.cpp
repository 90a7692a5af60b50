#include "render_client/display/overlay/overlay.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "common/gl/texture.h"
#include "tests/support/gl_test.h"

namespace copresence::overlay {
namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr Rgba8 kPicture{40, 80, 120, 255};

window::MoveEvent pointer(double x, double y, bool left) {
  return {.x = x, .y = y, .left = left, .right = false, .middle = false, .modifiers = {}};
}

window::ButtonEvent button(bool pressed, double x, double y) {
  return {.button = window::Button::kLeft, .pressed = pressed, .x = x, .y = y, .modifiers = {}};
}

Content notices(std::vector<std::string> lines) {
  Content content;
  content.notices = std::move(lines);
  return content;
}

/// Two cameras, of which the first has a graph of two stages with these times.
Content figures(float first_ms, float second_ms) {
  Content content;
  content.figures = {.headings = {"camera", "frames/s"},
                     .cameras = {{{"left", "30.0"}, {{first_ms, second_ms}}}, {{"right", "29.9"}, {}}},
                     .stages = {"wire", "decode"},
                     .view = {{"views", "59.9 per second"}}};
  content.switches = {{7, "C", "colour correction", "on"}, {9, "U", "unseen", "extend"}};
  return content;
}

class OverlayGl : public gl::GlTest {
 protected:
  void SetUp() override {
    gl::GlTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    texture_.emplace(context(), gl::Format::kRgba8, kWidth, kHeight);
    glCreateFramebuffers(1, &framebuffer_);
    glNamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, texture_->id(), 0);
    overlay_.emplace(context(), std::vector<Row>{{"F11", "full screen"}, {"Escape", "ends the client"}});
  }

  void TearDown() override {
    overlay_.reset();
    if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
    texture_.reset();
    gl::GlTest::TearDown();
  }

  /// Draws over a picture of one colour. Returns the result, top row first.
  Image<Rgba8> draw() {
    texture_->upload(Image<Rgba8>(kWidth, kHeight, kPicture));
    overlay_->draw(framebuffer_, kWidth, kHeight);
    Image<Rgba8> bottom_first, image(kWidth, kHeight);
    texture_->read(bottom_first);
    for (int y = 0; y < kHeight; ++y)
      std::copy(bottom_first.row(y).begin(), bottom_first.row(y).end(), image.row(kHeight - 1 - y).begin());
    return image;
  }

  /// Returns the number of pixels in these rows that differ from the picture.
  static int covered(const Image<Rgba8>& image, int first_row, int last_row) {
    int count = 0;
    for (int y = first_row; y <= last_row; ++y) {
      for (const Rgba8& pixel : image.row(y))
        count += pixel.r != kPicture.r || pixel.g != kPicture.g || pixel.b != kPicture.b;
    }
    return count;
  }

  Overlay& overlay() { return *overlay_; }

 private:
  std::optional<gl::Texture> texture_;
  GLuint framebuffer_ = 0;
  std::optional<Overlay> overlay_;
};

TEST_F(OverlayGl, DrawsNothingIfThereIsNothingToSay) {
  EXPECT_EQ(covered(draw(), 0, kHeight - 1), 0);
}

TEST_F(OverlayGl, WritesEachNoticeOnALineAtTheBottom) {
  overlay().set_content(notices({"waiting for left at host:1, third try: connection refused"}));
  const Image<Rgba8> one = draw();
  EXPECT_GT(covered(one, kHeight - 60, kHeight - 1), 3000);
  EXPECT_EQ(covered(one, 0, kHeight - 61), 0);
  overlay().set_content(notices({"waiting for left", "waiting for right"}));
  const Image<Rgba8> two = draw();
  EXPECT_NE(one, two);
  overlay().set_content({});
  EXPECT_EQ(covered(draw(), 0, kHeight - 1), 0);
}

TEST_F(OverlayGl, CountsNoticesThatDoNotFit) {
  overlay().set_content(notices(std::vector<std::string>(32, "waiting for host:1")));
  EXPECT_EQ(covered(draw(), 0, kHeight / 2), 0);
}

TEST_F(OverlayGl, BreaksNoticesThatAreWiderThanThePicture) {
  std::string words = "waiting";
  for (int i = 0; i < 14; ++i) words.append(" for left");
  overlay().set_content(notices({words}));
  const Image<Rgba8> image = draw();
  for (int y = 0; y < kHeight; ++y) {
    EXPECT_EQ(image(0, y), kPicture);
    EXPECT_EQ(image(kWidth - 1, y), kPicture);
  }
  EXPECT_GT(covered(image, kHeight - 60, kHeight - 1), 10'000);
}

TEST_F(OverlayGl, IsTheSameInEachPictureWhileNothingChanges) {
  overlay().set_content(figures(20, 60));
  overlay().toggle_figures();
  const Image<Rgba8> first = draw();
  EXPECT_EQ(draw(), first);
  overlay().take(pointer(3, 3, false));
  EXPECT_EQ(draw(), first) << "the pointer is not on the panel";
  overlay().set_content(figures(60, 20));
  EXPECT_NE(draw(), first);
}

TEST_F(OverlayGl, ListsTheKeysOnDemandOnly) {
  overlay().toggle_keys();
  EXPECT_GT(covered(draw(), 0, 80), 3000);
  overlay().toggle_keys();
  EXPECT_EQ(covered(draw(), 0, kHeight - 1), 0);
}

TEST_F(OverlayGl, KeepsADragThatBeginsOnAPanelFromTheView) {
  overlay().toggle_keys();
  const Image<Rgba8> image = draw();
  ASSERT_FALSE(image(kWidth - 40, 30) == kPicture) << "the panel is at the top right";
  EXPECT_FALSE(overlay().take(pointer(kWidth - 40, 30, false)));
  EXPECT_TRUE(overlay().take(window::ScrollEvent{0, 1}));
  EXPECT_TRUE(overlay().take(button(true, kWidth - 40, 30)));
  EXPECT_TRUE(overlay().take(pointer(100, 200, true)));
  EXPECT_TRUE(overlay().take(button(false, 100, 200)));
  EXPECT_FALSE(overlay().take(window::ScrollEvent{0, 1}));
  EXPECT_FALSE(overlay().take(button(true, 100, 200)));
  EXPECT_FALSE(overlay().take(pointer(kWidth - 40, 30, true))) << "this drag began on the view";
  EXPECT_FALSE(overlay().take(window::KeyEvent{window::Key{'R'}, true, false, {}}));
}

/// Returns the number of pixels of this colour.
int pixels_of(const Image<Rgba8>& image, Rgba8 color) {
  return static_cast<int>(std::count(image.pixels().begin(), image.pixels().end(), color));
}

TEST_F(OverlayGl, ShowsFiguresAndAGraphOfTheStagesOnDemandOnly) {
  const Rgba8 first{102, 194, 165, 255}, second{252, 141, 98, 255};  // kStageColors
  overlay().set_content(figures(20, 60));
  EXPECT_EQ(covered(draw(), 0, kHeight - 1), 0);
  overlay().toggle_figures();
  const Image<Rgba8> image = draw();
  EXPECT_GT(covered(image, 0, 150), 10'000);
  overlay().set_content(figures(0, 0));
  const Image<Rgba8> without = draw();  // The names of the stages have these colours, too.
  const int pixels_of_first = pixels_of(image, first) - pixels_of(without, first);
  const int pixels_of_second = pixels_of(image, second) - pixels_of(without, second);
  EXPECT_GT(pixels_of_first, 0);
  EXPECT_NEAR(pixels_of_second, 3 * pixels_of_first, 9) << "it takes three times as long";
}

TEST_F(OverlayGl, TellsWhichSwitchWasClicked) {
  overlay().set_content(figures(1, 1));
  overlay().toggle_figures();
  draw();
  EXPECT_TRUE(overlay().take_clicks().empty());
  std::vector<int> clicked;
  for (int y = 0; y < kHeight && clicked.size() < 2; y += 4) {
    overlay().take(button(true, 40, y));
    draw();
    overlay().take(button(false, 40, y));
    draw();
    for (const int id : overlay().take_clicks()) {
      if (clicked.empty() || clicked.back() != id) clicked.push_back(id);
    }
  }
  EXPECT_EQ(clicked, (std::vector{7, 9})) << "from top to bottom";
}

}  // namespace
}  // namespace copresence::overlay
