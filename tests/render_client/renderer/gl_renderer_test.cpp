#include "render_client/renderer/gl/gl_renderer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render_client/renderer/merge_rules.h"
#include "tests/support/gl_test.h"

namespace copresence::renderer {
namespace {

constexpr HostPixels kEverything{.color = true, .depth = true};

class GlRenderer : public gl::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto made = make_gl_renderer(context());
    ASSERT_TRUE(made.has_value()) << made.error().what;
    renderer_ = std::move(*made);
  }
  void TearDown() override {
    renderer_.reset();
    GlTest::TearDown();
  }

  MergedView render(std::span<const CameraView> cameras, const ViewPose& eye,
                    HostPixels wanted = kEverything) {
    MergedView view;
    const auto rendered = renderer_->render(cameras, eye, wanted, view);
    EXPECT_TRUE(rendered.has_value()) << rendered.error().what;
    return view;
  }

  std::unique_ptr<Renderer> renderer_;
};

// A wall perpendicular to the camera's axis.
RgbdFrame wall(int width, int height, std::uint16_t depth_mm, Rgb8 color) {
  RgbdFrame frame;
  frame.depth = DepthImage(width, height, depth_mm);
  frame.state = StateImage(width, height, DepthState::kMeasured);
  frame.color = ColorImage(width, height, color);
  return frame;
}

CameraView camera_at(const RgbdFrame& frame, double x_m) {
  CameraView camera;
  camera.frame = &frame;
  camera.version = 1;
  camera.model = camera_from_field_of_view(frame.depth.width(), frame.depth.height(), 1.0, 0.8);
  camera.world_from_camera.translation.x() = x_m;
  return camera;
}

ViewPose eye_of(const CameraView& camera) {
  ViewPose eye;
  eye.intrinsics = camera.model;
  eye.world_from_eye = camera.world_from_camera;
  return eye;
}

TEST_F(GlRenderer, ShowsTheSidesOfTrianglesAsLines) {
  const RgbdFrame frame = wall(160, 120, 2000, {200, 100, 50});
  const std::vector<CameraView> cameras{camera_at(frame, 0)};
  const auto shown = [&] {
    const MergedView view = render(cameras, eye_of(cameras[0]));
    const auto pixels = view.depth_m.pixels();
    return std::count_if(pixels.begin(), pixels.end(), [](float depth_m) { return depth_m > 0; });
  };
  const auto filled = shown();
  EXPECT_TRUE(renderer_->set_wireframe(true));
  const auto lines = shown();
  EXPECT_GT(lines, filled / 100);
  EXPECT_LT(lines, filled / 2);
  renderer_->set_wireframe(false);
  EXPECT_EQ(shown(), filled);
}

TEST_F(GlRenderer, ShowsAsManyCamerasAsItPromises) {
  const RgbdFrame frame = wall(16, 12, 2000, {200, 100, 50});
  std::vector<CameraView> cameras;
  for (std::size_t i = 0; i < kMostCameras; ++i) {
    cameras.push_back(camera_at(frame, 3.0 * static_cast<double>(i)));
    cameras.back().version = i + 1;
  }
  const CameraView& last = cameras.back();
  const MergedView view = render(cameras, eye_of(last));
  EXPECT_EQ(view.camera(8, 6), kMostCameras - 1);
  EXPECT_EQ(view.color(8, 6), (Rgba8{200, 100, 50, 255}));
}

// The wall of a stale camera is a metre in front of that of the live one.
TEST_F(GlRenderer, AStaleCameraGivesWayToALiveOneAndFades) {
  const RgbdFrame near = wall(64, 48, 1000, {200, 100, 50}), far = wall(64, 48, 2000, {0, 0, 250});
  CameraView stale = camera_at(near, 0), live = camera_at(far, 1.5);
  stale.version = 2;
  stale.opacity = 0.5F;
  const CameraView both[] = {stale, live};
  const ViewPose eye = eye_of(stale);
  const MergedView view = render(both, eye);
  EXPECT_EQ(view.camera(10, 24), 0) << "only the stale camera sees it";
  EXPECT_EQ(view.color(10, 24), (Rgba8{100, 50, 25, 255}));
  EXPECT_EQ(view.camera(60, 24), 1) << "the live camera sees it, though farther away";
  EXPECT_EQ(view.color(60, 24), (Rgba8{0, 0, 250, 255}));
  const CameraView gone[] = {[&] {
    CameraView camera = stale;
    camera.opacity = 0;
    return camera;
  }()};
  EXPECT_EQ(render(gone, eye).camera(10, 24), kNoCamera);
  EXPECT_EQ(render({&live, 1}, eye_of(live)).color(30, 24), (Rgba8{0, 0, 250, 255}));
}

TEST_F(GlRenderer, ShowsAWallAsItsCameraSawIt) {
  const RgbdFrame frame = wall(64, 48, 2000, {200, 100, 50});
  const CameraView camera = camera_at(frame, 0);
  const MergedView view = render({&camera, 1}, eye_of(camera));
  ASSERT_EQ(view.color.width(), 64);
  ASSERT_EQ(view.color.height(), 48);
  EXPECT_NE(view.texture, 0u);
  for (int y = 1; y < 47; ++y) {
    for (int x = 1; x < 63; ++x) {
      ASSERT_EQ(view.color(x, y), (Rgba8{200, 100, 50, 255})) << x << " " << y;
      ASSERT_NEAR(view.depth_m(x, y), 2.0, 1e-4);
      ASSERT_EQ(view.camera(x, y), 0);
      const Eigen::Vector3d ray = unproject(camera.model, {double(x), double(y)}, 1.0).normalized();
      const float fade = border_fade(std::min({x, 63 - x, y, 47 - y}), 64);
      ASSERT_NEAR(view.quality(x, y), fade * ray.z() / 4, 0.01) << "cos(theta) / z^2";
    }
  }
}

TEST_F(GlRenderer, ShowsNothingWhereThereIsNothing) {
  const RgbdFrame frame = wall(64, 48, 2000, {200, 100, 50});
  const CameraView camera = camera_at(frame, 0);
  ViewPose eye = eye_of(camera);
  const auto expect_nothing = [](const MergedView& view) {
    EXPECT_EQ(view.color, Image<Rgba8>(64, 48, Rgba8{0, 0, 0, 0}));
    EXPECT_EQ(view.depth_m, Image<float>(64, 48));
    EXPECT_EQ(view.quality, Image<float>(64, 48));
    EXPECT_EQ(view.camera, Image<std::uint8_t>(64, 48, kNoCamera));
  };
  expect_nothing(render({}, eye));
  eye.far_m = 1.9;
  expect_nothing(render({&camera, 1}, eye));
  eye = eye_of(camera);
  eye.near_m = 2.1;
  expect_nothing(render({&camera, 1}, eye));
  eye = eye_of(camera);
  eye.world_from_eye.rotation = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  expect_nothing(render({&camera, 1}, eye));
  eye.world_from_eye.translation.z() = 4;  // The eye looks at the back of the wall.
  expect_nothing(render({&camera, 1}, eye));
}

TEST_F(GlRenderer, LeavesOutHolesAndDoesNotBridgeSteps) {
  RgbdFrame frame = wall(64, 48, 2000, {255, 255, 255});
  for (int y = 0; y < 48; ++y) {
    for (int x = 32; x < 64; ++x) frame.depth(x, y) = 3000;
  }
  frame.depth(10, 10) = 0;
  frame.state(10, 10) = DepthState::kHole;
  const CameraView camera = camera_at(frame, 0);
  ViewPose eye = eye_of(camera);
  const MergedView ahead = render({&camera, 1}, eye);
  EXPECT_EQ(ahead.camera(10, 10), kNoCamera);
  EXPECT_EQ(ahead.camera(13, 10), 0);
  eye.world_from_eye.translation.x() = 0.5;  // From here, the depth step has a gap.
  const MergedView aside = render({&camera, 1}, eye);
  int gap = 0;
  for (int x = 0; x < 64; ++x) {
    gap += aside.camera(x, 24) == kNoCamera && x > 20 && x < 60;
    if (aside.depth_m(x, 24) > 0) {
      EXPECT_TRUE(std::abs(aside.depth_m(x, 24) - 2) < 1e-3 || std::abs(aside.depth_m(x, 24) - 3) < 1e-3)
          << "nothing hangs between the two";
    }
  }
  EXPECT_GT(gap, 3);
}

TEST_F(GlRenderer, LetsTheNearerCameraWinWithinTheRange) {
  // Both cameras see the wall at world z = 2, the second from half the distance.
  const RgbdFrame far = wall(64, 48, 2000, {255, 0, 0}), near = wall(64, 48, 1000, {0, 0, 255});
  std::array cameras = {camera_at(far, 0), camera_at(near, 0)};
  cameras[1].world_from_camera.translation.z() = 1.005;
  const MergedView view = render(cameras, eye_of(cameras[0]));
  EXPECT_EQ(view.color(32, 24), (Rgba8{0, 0, 255, 255}));
  EXPECT_EQ(view.camera(32, 24), 1);
  EXPECT_NEAR(view.depth_m(32, 24), 2.005, 1e-4);
  EXPECT_NEAR(view.quality(32, 24), 1.0, 0.01);
}

TEST_F(GlRenderer, HidesWhatLiesBehindTheRange) {
  const RgbdFrame far = wall(64, 48, 3000, {255, 0, 0}), near = wall(64, 48, 2000, {0, 0, 255});
  const std::array cameras = {camera_at(far, 0), camera_at(near, 0)};
  const MergedView view = render(cameras, eye_of(cameras[0]));
  EXPECT_EQ(view.color(32, 24), (Rgba8{0, 0, 255, 255}));
  EXPECT_EQ(view.camera(32, 24), 1);
}

TEST_F(GlRenderer, BlendsEqualsAndPrefersMeasuredToFilled) {
  const RgbdFrame red = wall(64, 48, 2000, {200, 0, 0});
  RgbdFrame blue = wall(64, 48, 2000, {0, 0, 200});
  const std::array cameras = {camera_at(red, 0), camera_at(blue, 0)};
  const MergedView blended = render(cameras, eye_of(cameras[0]));
  EXPECT_EQ(blended.color(32, 24), (Rgba8{100, 0, 100, 255}));
  EXPECT_EQ(blended.camera(32, 24), 0) << "the lowest index of equals";

  blue.state = StateImage(64, 48, DepthState::kFilled);
  std::array again = cameras;
  again[1].version = 2;
  const MergedView view = render(again, eye_of(cameras[0]));
  EXPECT_EQ(view.color(32, 24), (Rgba8{200, 0, 0, 255}));
}

TEST_F(GlRenderer, MatchesColors) {
  const RgbdFrame frame = wall(64, 48, 2000, {100, 100, 100});
  CameraView camera = camera_at(frame, 0);
  render({&camera, 1}, eye_of(camera));
  camera.color_correction << 0.5F, 0, 0, 0, 0, 1, 0, 0.1F, 0, 0, 3,
      0;  // The frame is the same. Only the correction is new.
  const MergedView view = render({&camera, 1}, eye_of(camera));
  EXPECT_EQ(view.color(32, 24), (Rgba8{50, 126, 255, 255}));
}

TEST_F(GlRenderer, ShadesWithoutColorByTheNormals) {
  RgbdFrame frame = wall(64, 48, 2000, {});
  frame.color.reset();
  const CameraView camera = camera_at(frame, 0);
  const MergedView view = render({&camera, 1}, eye_of(camera));
  EXPECT_NEAR(view.color(32, 24).r, 255, 1);
  const double corner = 255 * shade_without_color(float(unproject(camera.model, {2, 2}, 1).normalized().z()));
  EXPECT_NEAR(view.color(2, 2).r, corner, 6) << "of the cell, that is";
}

TEST_F(GlRenderer, KeepsWhatDidNotChangeAndTakesWhatDid) {
  RgbdFrame frame = wall(64, 48, 2000, {10, 20, 30});
  CameraView camera = camera_at(frame, 0);
  const ViewPose eye = eye_of(camera);
  render({&camera, 1}, eye);
  frame = wall(64, 48, 1500, {40, 50, 60});
  EXPECT_EQ(render({&camera, 1}, eye).color(32, 24), (Rgba8{10, 20, 30, 255}))
      << "the version says nothing new";
  camera.version = 2;
  const MergedView view = render({&camera, 1}, eye);
  EXPECT_EQ(view.color(32, 24), (Rgba8{40, 50, 60, 255}));
  EXPECT_NEAR(view.depth_m(32, 24), 1.5, 1e-4);
}

TEST_F(GlRenderer, FollowsCamerasAndSizesThatChange) {
  const RgbdFrame small = wall(32, 24, 2000, {10, 20, 30}), large = wall(64, 48, 2000, {40, 50, 60});
  const std::array both = {camera_at(small, 0), camera_at(large, 0)};
  EXPECT_EQ(render(both, eye_of(both[0])).color.width(), 32);
  const MergedView only_large = render({&both[1], 1}, eye_of(both[1]));
  EXPECT_EQ(only_large.color(32, 24), (Rgba8{40, 50, 60, 255}));
  CameraView narrow = both[1];
  narrow.model = camera_from_field_of_view(64, 48, 0.5, 0.4);
  const MergedView view = render({&narrow, 1}, eye_of(both[1]));
  EXPECT_EQ(view.camera(32, 24), 0);
  EXPECT_EQ(view.camera(2, 2), kNoCamera) << "a narrower camera covers less of the view";
}

TEST_F(GlRenderer, GivesOnlyWhatWasAskedFor) {
  const RgbdFrame frame = wall(64, 48, 2000, {10, 20, 30});
  const CameraView camera = camera_at(frame, 0);
  const MergedView nothing = render({&camera, 1}, eye_of(camera), {});
  EXPECT_TRUE(nothing.color.empty() && nothing.depth_m.empty() && nothing.camera.empty() &&
              nothing.quality.empty());
  EXPECT_NE(nothing.texture, 0u);
  EXPECT_EQ(nothing.width, 64);
  const MergedView color = render({&camera, 1}, eye_of(camera), {.color = true});
  EXPECT_FALSE(color.color.empty());
  EXPECT_TRUE(color.depth_m.empty());
}

TEST_F(GlRenderer, DrawsEveryEyeIntoAPictureOfItsOwn) {
  const RgbdFrame frame = wall(64, 48, 2000, {10, 20, 30});
  const CameraView camera = camera_at(frame, 0);
  MergedView left, right;
  right.target = 1;
  for (int view = 0; view < 2; ++view) {
    const std::uint32_t before = left.texture;
    ASSERT_TRUE(renderer_->render({&camera, 1}, eye_of(camera), {}, left).has_value());
    ASSERT_TRUE(renderer_->render({&camera, 1}, eye_of(camera), kEverything, right).has_value());
    EXPECT_NE(left.texture, right.texture);
    EXPECT_EQ(right.color(32, 24), (Rgba8{10, 20, 30, 255}));
    if (view > 0) {
      EXPECT_EQ(left.texture, before) << "its target is used again";
    }
  }
}

TEST_F(GlRenderer, UndoesTheLensesDistortion) {
  RgbdFrame frame = wall(64, 48, 2000, {10, 20, 30});
  CameraView camera = camera_at(frame, 0);
  const ViewPose eye = eye_of(camera);
  camera.model.distortion = {-0.2, 0, 0, 0, 0, 0, 0, 0};
  frame.color->operator()(8, 8) = {250, 250, 250};
  const MergedView view = render({&camera, 1}, eye);
  const Eigen::Vector2d where = project(eye.intrinsics, unproject(camera.model, {8, 8}, 2.0));
  EXPECT_LT(where.x(), 7) << "barrel distortion had pulled the corner in";
  const auto near = view.color(int(std::lround(where.x())), int(std::lround(where.y())));
  EXPECT_GT(near.r, 60);
}

}  // namespace
}  // namespace copresence::renderer
