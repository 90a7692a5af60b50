// Holds the shaders to the CPU's joint filling, which is the reference.

#include "capture_server/hole_filling/gl_joint_filling.h"

#include <cmath>
#include <vector>

#include "capture_server/hole_filling/joint_filling.h"
#include "tests/capture_server/hole_filling/scenes.h"
#include "tests/support/gl_test.h"

namespace copresence::hole_filling {
namespace {

class GlJointFillingTest : public gl::GlTest {
 protected:
  /// Fills scenes of one size both ways and counts the pixels that differ in state, or in depth by more than
  /// a tenth of a step.
  void expect_same(const std::vector<Scene>& scenes) {
    auto shaders = GlJointFilling::open(context(), scenes.front().format());
    ASSERT_TRUE(shaders) << shaders.error().what;
    JointFilling reference(scenes.front().format());
    for (const Scene& scene : scenes) {  // nothing of one frame may be left in the next
      RgbdFrame by_cpu = scene.frame, by_gl = scene.frame;
      ASSERT_TRUE(reference.fill(by_cpu));
      ASSERT_TRUE((*shaders)->fill(by_gl));
      compare(by_cpu, by_gl);
    }
  }

 private:
  static void compare(const RgbdFrame& by_cpu, const RgbdFrame& by_gl) {
    int differ = 0, filled = 0;
    for (std::size_t i = 0; i < by_cpu.depth.pixels().size(); ++i) {
      const auto cpu = by_cpu.depth.pixels()[i], gl = by_gl.depth.pixels()[i];
      filled += by_cpu.state.pixels()[i] == DepthState::kFilled;
      if (by_cpu.state.pixels()[i] != by_gl.state.pixels()[i]) {
        ++differ;
      } else if (cpu != gl) {
        differ += std::abs(cpu - gl) > 1 && steps_apart(cpu, gl) > 0.1;
      }
    }
    EXPECT_LE(differ, 0.001 * filled) << "of " << filled << " filled pixels";
  }
};

/// A slanted floor, a board before it, a ball, and noise of a step: enough for every rule to decide
/// something.
double furnished(int x, int y) {
  double z = slanted_plane(x / 2, y / 2);
  if (x > 100 && x < 160 && y > 40 && y < 150) z = 1.0 + 0.001 * (x - 100);
  const double ball = 50.0 * 50.0 - (x - 230) * (x - 230) - (y - 120) * (y - 120);
  if (ball > 0) z = 1.1 - 0.004 * std::sqrt(ball);
  const unsigned noise = static_cast<unsigned>(x * 2654435761u + y * 40503u) >> 13 & 7u;
  return z + (static_cast<double>(noise) - 3.5) / 7 * z * z / 351.3;
}

bool holes_and_shadows(int x, int y) {
  return speckle(x, y) || (x >= 76 && x <= 101 && y > 38 && y < 152) ||
         (x > 170 && x < 186 && y > 80 && y < 160) || x < 6 || x >= 314;
}

TEST_F(GlJointFillingTest, AgreesWithTheCpuWithAndWithoutColor) {
  Scene scene = Scene::make(320, 240, furnished, holes_and_shadows);
  scene.frame.color = ColorImage(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const auto light = static_cast<std::uint8_t>(scene.truth(x, y) < 13000 ? 200 - x / 4 : 60 + y / 4);
      (*scene.frame.color)(x, y) = {light, static_cast<std::uint8_t>(255 - light), 90};
    }
  }
  Scene colorless = scene;
  colorless.frame.color.reset();
  expect_same({scene, colorless, scene});
}

TEST_F(GlJointFillingTest, AgreesWithTheCpuOnOddShapesAndEmptyFrames) {
  for (const auto& [width, height] : {std::pair{2, 2}, {66, 50}}) {
    expect_same({Scene::make(width, height, furnished, speckle),
                 Scene::make(width, height, furnished, [](int, int) { return true; }),
                 Scene::make(width, height, furnished, [](int, int) { return false; }),
                 Scene::make(width, height, furnished, speckle)});
  }
}

TEST(HoleFillingChoice, TakesGlWhereAskedAndCpuWhereGlIsSoftware) {
  auto context = gl::Context::headless();
  if (!context) GTEST_SKIP() << context.error().what;
  const bool software = (*context)->is_software();
  context->reset();
  EXPECT_EQ(open(Method::kJoint, Compute::kGl, {}).value()->name(), "gl");
  EXPECT_EQ(open(Method::kJoint, Compute::kCpu, {}).value()->name(), "cpu");
  EXPECT_EQ(open(Method::kJoint, Compute::kAuto, {}).value()->name(), software ? "cpu" : "gl");
  EXPECT_EQ(open(Method::kMedian, Compute::kAuto, {}).value()->name(), "cpu");
  EXPECT_EQ(open(Method::kMedian, Compute::kGl, {}).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace copresence::hole_filling
