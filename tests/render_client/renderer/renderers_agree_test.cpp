// Compares the pictures of the two renderers: same cameras, same eye, same view.

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "common/executor.h"
#include "render_client/renderer/cpu/cpu_renderer.h"
#include "render_client/renderer/gl/gl_renderer.h"
#include "tests/render_client/renderer/surfaces.h"
#include "tests/support/gl_test.h"

namespace copresence::renderer {
namespace {

constexpr int kWidth = 480, kHeight = 270;

// Half the size of a Kinect's images, to be fast.
CameraModel half_kinect_model() {
  return {320, 240, 292.5, 292.5, 159.75, 119.75, {}};
}

Surface seen_from(const Rigid3& world_from_camera, const Eigen::Vector3d& n, double d) {
  return plane(world_from_camera.rotation.transpose() * n, d - n.dot(world_from_camera.translation));
}

// Two walls that meet, a floor, and a ball in front of them. Metres; the world has the camera
// convention.
Surface room(const Rigid3& world_from_camera) {
  const Eigen::Vector3d ball(0.1, 0.2, 1.8);
  return together(
      {seen_from(world_from_camera, {0.3, 0, 1}, 3), seen_from(world_from_camera, {-0.5, 0, 1}, 3.2),
       seen_from(world_from_camera, {0, 1, 0}, 0.9), sphere(world_from_camera.inverse() * ball, 0.35)});
}

struct Scene {
  std::vector<RgbdFrame> frames;
  std::vector<CameraView> cameras;
};

struct Sensing {
  bool color = true;
  bool noise = false;
};

// Two cameras, half a metre apart, that look at the ball.
Scene scene(const Sensing& sensing) {
  Scene made;
  made.frames.reserve(2);
  for (int i = 0; i < 2; ++i) {
    CameraView camera;
    camera.model = half_kinect_model();
    camera.unit = DepthUnit::k100Micrometres;
    camera.version = 1;
    camera.world_from_camera.translation.x() = i == 0 ? -0.25 : 0.25;
    camera.world_from_camera.rotation = turned(i == 0 ? 8 : -8);
    if (i == 1) camera.color_correction << 0.9F, 0.05F, 0, 0.01F, 0, 1.1F, 0, 0, 0.02F, 0, 0.95F, -0.01F;
    made.frames.push_back(frame_of(camera.model, room(camera.world_from_camera),
                                   sensing.color ? std::optional(Paint(gradient)) : std::nullopt));
    if (sensing.noise) measure_like_a_kinect(made.frames.back(), 0.04, unsigned(i));
    // Filled pixels.
    for (int v = 50; v < 80; ++v) {
      for (int u = 100; u < 150; ++u) {
        auto& state = made.frames.back().state(u, v);
        if (state == DepthState::kMeasured) state = DepthState::kFilled;
      }
    }
    made.cameras.push_back(camera);
  }
  for (int i = 0; i < 2; ++i) made.cameras[i].frame = &made.frames[i];
  return made;
}

// Percentages of the view, and of the pixels shown in both views.
struct Difference {
  double shown_in_one = 0;
  double color = 0;   // differ by more than 8/255
  double winner = 0;  // show different cameras
  double depth = 0;   // of the same camera, and differ by more than a millimetre plus the sensor's sigma
};

std::ostream& operator<<(std::ostream& out, const Difference& d) {
  return out << "shown in one only " << d.shown_in_one << " %, colour " << d.color << " %, winner "
             << d.winner << " %, depth " << d.depth << " %";
}

Difference compare(const MergedView& a, const MergedView& b) {
  double both = 0;
  Difference count;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const float p_m = a.depth_m(x, y), q_m = b.depth_m(x, y);
      count.shown_in_one += (p_m > 0) != (q_m > 0);
      if (p_m == 0 || q_m == 0) continue;
      ++both;
      const Rgba8 p = a.color(x, y), q = b.color(x, y);
      count.color += std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)}) > 8;
      const bool same_winner = a.camera(x, y) == b.camera(x, y);
      count.winner += !same_winner;
      if (!same_winner) continue;
      count.depth += std::abs(p_m - q_m) > 0.001 + kKinectV1Noise.sigma_m(p_m);
    }
  }
  EXPECT_GT(both, a.width * a.height / 3);
  const double per_view = 100.0 / (a.width * a.height), per_pixel = 100 / both;
  return {count.shown_in_one * per_view, count.color * per_pixel, count.winner * per_pixel,
          count.depth * per_pixel};
}

class RenderersAgree : public gl::GlTest {
 protected:
  // The worst values over several eyes.
  Difference differ(const Scene& scene, int largest_block, MergeMode mode = MergeMode::kBlend) {
    InlineExecutor workers;
    const auto cpu = make_cpu_renderer(workers, {.largest_block = largest_block});
    const auto gl = make_gl_renderer(context(), {.largest_block = largest_block});
    if (!gl) {
      ADD_FAILURE() << gl.error().what;
      return {};
    }
    cpu->set_merge(mode);
    (*gl)->set_merge(mode);
    Difference worst;
    for (const double degrees : {-20.0, 3.0, 14.0}) {
      const ViewPose eye = orbiting_eye(kWidth, kHeight, degrees, 2);
      MergedView ours, theirs;
      constexpr HostPixels kAll{.color = true, .depth = true};
      EXPECT_TRUE(cpu->render(scene.cameras, eye, kAll, ours));
      EXPECT_TRUE((*gl)->render(scene.cameras, eye, kAll, theirs));
      const Difference here = compare(ours, theirs);
      std::cout << degrees << " degrees: " << here << '\n';
      worst = {std::max(worst.shown_in_one, here.shown_in_one), std::max(worst.color, here.color),
               std::max(worst.winner, here.winner), std::max(worst.depth, here.depth)};
    }
    return worst;
  }

  // Compares origins, and the colours of pixels that neither camera sees.
  void compare_unseen(const Scene& room) {
    InlineExecutor workers;
    const auto cpu = make_cpu_renderer(workers);
    const auto gl = make_gl_renderer(context());
    ASSERT_TRUE(gl);
    for (const auto show : {UnseenStyle::Show::kExtend, UnseenStyle::Show::kDim, UnseenStyle::Show::kBlack}) {
      cpu->set_unseen({.show = show, .background = {40, 60, 90}});
      (*gl)->set_unseen({.show = show, .background = {40, 60, 90}});
      for (const double degrees : {-20.0, 14.0}) {
        const ViewPose eye = orbiting_eye(kWidth, kHeight, degrees, 2);
        MergedView ours, theirs;
        constexpr HostPixels kAll{.color = true, .depth = true};
        ASSERT_TRUE(cpu->render(room.cameras, eye, kAll, ours));
        ASSERT_TRUE((*gl)->render(room.cameras, eye, kAll, theirs));
        double other_origin = 0, other_color = 0, unseen = 0;
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            other_origin += ours.origin(x, y) != theirs.origin(x, y);
            if (ours.origin(x, y) == Origin::kSeen || ours.origin(x, y) != theirs.origin(x, y)) continue;
            const Rgba8 p = ours.color(x, y), q = theirs.color(x, y);
            other_color += std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)}) > 8;
            ++unseen;
          }
        }
        ASSERT_GT(unseen, 1000);
        EXPECT_LE(100 * other_origin / (kWidth * kHeight), 0.2) << int(show) << " at " << degrees;
        EXPECT_LE(100 * other_color / unseen, 2) << int(show) << " at " << degrees;
      }
    }
  }
};

// Only rounding may differ. Where a rounded number decides, either result is right. The CPU
// renderer may also draw a noisy quad as one plane, which differs by a quarter of its noise.
void expect_agreement(const Difference& worst) {
  EXPECT_LE(worst.shown_in_one, 0.1);
  EXPECT_LE(worst.color, 0.2);
  EXPECT_LE(worst.winner, 0.5);
  EXPECT_LE(worst.depth, 1);
}

TEST_F(RenderersAgree, OnASmoothRoom) {
  expect_agreement(differ(scene({}), 16));
}

TEST_F(RenderersAgree, OnTheBestPixels) {
  expect_agreement(differ(scene({}), 16, MergeMode::kBest));
}

TEST_F(RenderersAgree, OnTheNearestPixels) {
  Difference worst = differ(scene({}), 16, MergeMode::kNearest);
  // Rounding decides which of two cameras shows a surface that both see.
  EXPECT_LT(worst.winner, 15);
  EXPECT_LE(worst.color, worst.winner + 0.2);
  worst.color = worst.winner = 0;
  expect_agreement(worst);
}

TEST_F(RenderersAgree, OnARoomAsAKinectSeesIt) {
  expect_agreement(differ(scene({.noise = true}), 16));
}

TEST_F(RenderersAgree, OnARoomAsAKinectSeesItPixelByPixel) {
  expect_agreement(differ(scene({.noise = true}), 1));
}

// First one camera fades, then both, by different amounts.
TEST_F(RenderersAgree, OnStaleCameras) {
  Scene stale = scene({.noise = true});
  stale.cameras[0].opacity = 0.4F;
  expect_agreement(differ(stale, 16));
  stale.cameras[1].opacity = 0.7F;
  expect_agreement(differ(stale, 16));
}

// The second camera's surface is a remembered background.
TEST_F(RenderersAgree, OnRememberedBackgrounds) {
  InlineExecutor workers;
  const auto cpu = make_cpu_renderer(workers);
  const auto gl = make_gl_renderer(context());
  ASSERT_TRUE(gl);
  Scene remembered = scene({.noise = true});
  remembered.cameras[1].is_remembered = true;
  for (const auto show : {UnseenStyle::Show::kExtend, UnseenStyle::Show::kDim, UnseenStyle::Show::kBlack}) {
    cpu->set_unseen({.show = show});
    (*gl)->set_unseen({.show = show});
    const ViewPose eye = orbiting_eye(kWidth, kHeight, 14.0, 2);
    MergedView ours, theirs;
    constexpr HostPixels kAll{.color = true, .depth = true};
    ASSERT_TRUE(cpu->render(remembered.cameras, eye, kAll, ours));
    ASSERT_TRUE((*gl)->render(remembered.cameras, eye, kAll, theirs));
    int remembered_pixels = 0, other_origin = 0, other_color = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool is_ours = ours.origin(x, y) == Origin::kRemembered;
        remembered_pixels += is_ours;
        other_origin += is_ours != (theirs.origin(x, y) == Origin::kRemembered);
        if (!is_ours || theirs.origin(x, y) != Origin::kRemembered) continue;
        const Rgba8 p = ours.color(x, y), q = theirs.color(x, y);
        other_color += std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)}) > 8;
      }
    }
    if (show == UnseenStyle::Show::kBlack) {
      EXPECT_EQ(remembered_pixels + other_origin, 0);
      continue;
    }
    EXPECT_GT(remembered_pixels, kWidth * kHeight / 100);
    EXPECT_LT(other_origin, 0.002 * kWidth * kHeight);
    EXPECT_LT(other_color, 0.01 * remembered_pixels);
  }
}

TEST_F(RenderersAgree, OnACameraThatIsGone) {
  Scene gone = scene({.noise = true});
  gone.cameras[1].opacity = 0;
  expect_agreement(differ(gone, 16));
}

TEST_F(RenderersAgree, OnWhatNoCameraHasSeen) {
  compare_unseen(scene({.noise = true}));
}

// Both cameras leave out a part of the picture with the ball's border.
TEST_F(RenderersAgree, OnPixelsThatAreLeftOut) {
  Scene room = scene({.noise = true});
  for (RgbdFrame& frame : room.frames) {
    for (int v = 90; v < 200; ++v) {
      for (int u = 60; u < 160; ++u) frame.depth(u, v) = 0;  // The states stay.
    }
  }
  expect_agreement(differ(room, 16));
  compare_unseen(room);
}

TEST_F(RenderersAgree, OnARoomWithoutColor) {
  expect_agreement(differ(scene({.color = false, .noise = true}), 8));
}

}  // namespace
}  // namespace copresence::renderer
