#include "common/gl/context.h"

#include <epoxy/gl.h>

#include <cstdlib>
#include <thread>

#include "common/gl/texture.h"
#include "tests/support/gl_test.h"

namespace copresence::gl {
namespace {

using ContextGl = GlTest;

TEST(Context, ExistsOnCi) {
  if (!std::getenv("CI")) GTEST_SKIP() << "CI is not set: a machine without OpenGL is allowed";
  const auto context = Context::headless();
  ASSERT_TRUE(context.has_value()) << context.error().what;
}

TEST(Context, KnowsSoftwareByItsName) {
  EXPECT_TRUE(is_software_renderer("llvmpipe (LLVM 15.0.6, 256 bits)"));
  EXPECT_TRUE(is_software_renderer("softpipe"));
  EXPECT_TRUE(is_software_renderer("SWR (LLVM 12)"));
  EXPECT_TRUE(is_software_renderer("Software Rasterizer"));
  EXPECT_TRUE(is_software_renderer("zink (llvmpipe (LLVM 15.0.6, 256 bits))"));
  EXPECT_FALSE(is_software_renderer("Mesa Intel(R) UHD Graphics 620 (KBL GT2)"));
  EXPECT_FALSE(is_software_renderer("NVIDIA GeForce RTX 3060/PCIe/SSE2"));
  EXPECT_FALSE(is_software_renderer("AMD Radeon RX 6600 (navi23, LLVM 15.0.6, DRM 3.49)"));
}

TEST_F(ContextGl, IsOfTheVersionWeAskFor) {
  EXPECT_EQ(context().version().substr(0, 3), "4.5") << context().version();
  EXPECT_FALSE(context().renderer_name().empty());
}

TEST_F(ContextGl, ReportsAMistakeOnceAndInWords) {
  Texture texture(context(), Format::kR32f, 4, 4);
  texture.bind(100000);
  const auto checked = context().check("binding a texture");
  ASSERT_FALSE(checked.has_value());
  EXPECT_EQ(checked.error().what.find("binding a texture: "), 0u) << checked.error().what;
  EXPECT_TRUE(context().check("nothing").has_value());
}

// A window's context lives a little longer than the object: the driver must not write into it then.
TEST_F(ContextGl, LeavesNoCallbackBehindInAContextThatLivesOn) {
  void* reports_to = nullptr;
  {
    const auto borrowed = Context::of_current(Debug::kOn);
    ASSERT_TRUE(borrowed.has_value()) << borrowed.error().what;
    glGetPointerv(GL_DEBUG_CALLBACK_USER_PARAM, &reports_to);
    EXPECT_NE(reports_to, nullptr);
  }
  glGetPointerv(GL_DEBUG_CALLBACK_USER_PARAM, &reports_to);
  EXPECT_EQ(reports_to, nullptr);
  void* callback = nullptr;
  glGetPointerv(GL_DEBUG_CALLBACK_FUNCTION, &callback);
  EXPECT_EQ(callback, nullptr);
}

TEST_F(ContextGl, OutlivesAnotherOnTheSameDisplay) {
  std::thread([] { EXPECT_TRUE(Context::headless().has_value()); }).join();
  auto another = std::thread([] {
    auto made = Context::headless();
    ASSERT_TRUE(made.has_value());
    Texture texture(**made, Format::kRgba8, 8, 8);
    EXPECT_TRUE((*made)->check("making a texture").has_value());
  });
  another.join();
  Texture texture(context(), Format::kRgba8, 8, 8);
  Image<Rgba8> pixels;
  texture.read(pixels);
  EXPECT_EQ(pixels, Image<Rgba8>(8, 8, Rgba8{0, 0, 0, 0}));
}

TEST_F(ContextGl, WithoutDebugOutputKnowsTheErrorsName) {
  std::thread([] {
    const auto quiet = Context::headless(Debug::kOff);
    ASSERT_TRUE(quiet.has_value());
    Texture texture(**quiet, Format::kR32f, 4, 4);
    texture.bind(100000);
    const auto checked = (*quiet)->check("binding");
    ASSERT_FALSE(checked.has_value());
    EXPECT_EQ(checked.error().what.substr(0, 16), "binding: invalid");
    EXPECT_TRUE((*quiet)->check("nothing").has_value());
  }).join();
}

}  // namespace
}  // namespace copresence::gl
