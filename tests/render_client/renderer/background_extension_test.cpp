// Views of scenes with known surfaces behind the objects that hide them.

#include <algorithm>
#include <cmath>

#include "render_client/renderer/extension_rules.h"
#include "tests/render_client/renderer/rendering.h"

namespace copresence::renderer {
namespace {

constexpr int kWidth = 480, kHeight = 270;
constexpr Rgb8 kWall{60, 120, 180}, kPerson{220, 40, 30};

// A wall at 3 m, with an upright post of 0.4 m width in front of it at 1.5 m.
Surface post_and_wall() {
  return [](double x, double) -> std::optional<double> {
    constexpr double kPostM = 1.5, kHalfWidthM = 0.2;
    return std::abs(x) * kPostM < kHalfWidthM ? kPostM : 3.0;
  };
}

Paint post_and_wall_colors(const CameraModel& model) {
  return [model](int u, int) { return std::abs(u - model.cx) / model.fx * 1.5 < 0.2 ? kPerson : kWall; };
}

MergedView render_unseen(const std::vector<Looking*>& cameras, const ViewPose& eye, const UnseenStyle& style,
                         int threads = 1) {
  flow::WorkerPool workers(threads, "test");
  const auto renderer = make_cpu_renderer(workers);
  renderer->set_unseen(style);
  MergedView view;
  EXPECT_TRUE(renderer->render(views_of(cameras), eye, {.color = true, .depth = true}, view));
  return view;
}

double share(const MergedView& view, Origin origin) {
  const auto pixels = view.origin.pixels();
  return double(std::count(pixels.begin(), pixels.end(), origin)) / double(pixels.size());
}

class PostBeforeAWall : public ::testing::Test {
 protected:
  PostBeforeAWall()
      : camera_(kinect_model(), post_and_wall(), post_and_wall_colors(kinect_model())),
        eye_(orbiting_eye(kWidth, kHeight, 12, 2)) {}

  MergedView view(const UnseenStyle& style) { return render_unseen({&camera_}, eye_, style); }

  Looking camera_;
  ViewPose eye_;
};

TEST_F(PostBeforeAWall, ItsShadowShowsTheWallAndNothingOfThePost) {
  const MergedView view = this->view({.show = UnseenStyle::Show::kExtend});
  ASSERT_GT(share(view, Origin::kExtended), 0.02);
  int wrong = 0, extended = 0;
  for (int y = kHeight / 4; y < 3 * kHeight / 4; ++y) {
    for (int x = kWidth / 4; x < 3 * kWidth / 4; ++x) {
      if (view.origin(x, y) != Origin::kExtended) continue;
      ++extended;
      const Eigen::Vector3d point = shown_point(view, eye_, x, y);
      wrong += !near_color(view.color(x, y), kWall, 12) || std::abs(point.z() - 3) > 0.1;
    }
  }
  ASSERT_GT(extended, 500);
  EXPECT_LE(wrong, extended / 50);
}

TEST_F(PostBeforeAWall, AnExtendedWallShowsNothingOfAPostThatIsLeftOut) {
  int left_out = 0;
  for (std::uint16_t& depth : camera_.frame.depth.pixels()) {
    if (depth > 20000) continue;
    depth = 0;  // The state stays.
    ++left_out;
  }
  ASSERT_GT(left_out, 10000);
  const MergedView view =
      render_unseen({&camera_}, orbiting_eye(kWidth, kHeight, 0, 2), {.show = UnseenStyle::Show::kExtend});
  int extended = 0, wrong = 0;
  for (int y = kHeight / 4; y < 3 * kHeight / 4; ++y) {
    for (int x = kWidth / 3; x < 2 * kWidth / 3; ++x) {
      if (view.origin(x, y) != Origin::kExtended) continue;
      ++extended;
      wrong += !near_color(view.color(x, y), kWall, 12);
    }
  }
  EXPECT_GT(extended, 1000);
  EXPECT_EQ(wrong, 0);
}

TEST_F(PostBeforeAWall, NoSeenPixelChanges) {
  const MergedView extended = view({.show = UnseenStyle::Show::kExtend}), plain = view({});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(plain.origin(x, y) == Origin::kSeen, extended.origin(x, y) == Origin::kSeen);
      if (plain.origin(x, y) != Origin::kSeen) continue;
      ASSERT_EQ(plain.color(x, y), extended.color(x, y));
      ASSERT_EQ(plain.depth_m(x, y), extended.depth_m(x, y));
    }
  }
}

TEST_F(PostBeforeAWall, NoHairlineIsLeftFromTheCamerasOwnPose) {
  eye_ = eye_at_origin(kWidth, kHeight);
  const MergedView view = this->view({.show = UnseenStyle::Show::kExtend});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 5; x < 4 * kWidth / 5; ++x)
      ASSERT_NE(view.origin(x, y), Origin::kEmpty) << x << ' ' << y;
  }
}

TEST_F(PostBeforeAWall, DimmedSurfacesHaveHalfTheBrightness) {
  const MergedView bright = view({.show = UnseenStyle::Show::kExtend});
  const MergedView dim = view({.show = UnseenStyle::Show::kDim});
  int compared = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(bright.origin(x, y), dim.origin(x, y));
      if (bright.origin(x, y) != Origin::kExtended) continue;
      ASSERT_NEAR(dim.color(x, y).b, 0.5 * bright.color(x, y).b, 1);
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

TEST_F(PostBeforeAWall, EmptyPixelsShowTheBackground) {
  for (const auto show : {UnseenStyle::Show::kExtend, UnseenStyle::Show::kBlack}) {
    eye_ = orbiting_eye(kWidth, kHeight, 40, 2);  // The view extends beyond the camera's picture.
    const MergedView view = this->view({.show = show, .background = {10, 20, 30}});
    int empty = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (view.origin(x, y) != Origin::kEmpty) continue;
        ASSERT_EQ(view.color(x, y), (Rgba8{10, 20, 30, 0}));
        ++empty;
      }
    }
    EXPECT_GT(empty, 500);
  }
}

TEST_F(PostBeforeAWall, SharesCountEveryPixelOnce) {
  for (const auto show : {UnseenStyle::Show::kExtend, UnseenStyle::Show::kBlack}) {
    const MergedView view = this->view({.show = show});
    ASSERT_TRUE(view.shares);
    EXPECT_NEAR(view.shares->seen, share(view, Origin::kSeen), 1e-6);
    EXPECT_NEAR(view.shares->extended, share(view, Origin::kExtended), 1e-6);
    EXPECT_NEAR(view.shares->empty, share(view, Origin::kEmpty), 1e-6);
  }
}

TEST_F(PostBeforeAWall, TheNumberOfThreadsChangesNothing) {
  const UnseenStyle style{.show = UnseenStyle::Show::kExtend};
  const MergedView one = render_unseen({&camera_}, eye_, style, 1),
                   three = render_unseen({&camera_}, eye_, style, 3);
  EXPECT_TRUE(std::ranges::equal(one.color.pixels(), three.color.pixels()));
  EXPECT_TRUE(std::ranges::equal(one.depth_m.pixels(), three.depth_m.pixels()));
}

// The camera sees colour but no depth in a window.
class WindowInAWall : public ::testing::Test {
 protected:
  static constexpr Rgb8 kSky{230, 240, 250};
  static bool is_window(double x, double y) { return std::abs(x) < 0.12 && std::abs(y) < 0.1; }

  WindowInAWall()
      : camera_(
            kinect_model(),
            [](double x, double y) { return is_window(x, y) ? std::nullopt : std::optional(2.5); },
            [](int u, int v) {
              const CameraModel model = kinect_model();
              return is_window((u - model.cx) / model.fx, (v - model.cy) / model.fy) ? kSky : kWall;
            }) {}

  Looking camera_;
};

TEST_F(WindowInAWall, ShowsTheColorOfTheWindowOnTheWall) {
  for (const double degrees : {0.0, 15.0}) {
    const ViewPose eye = orbiting_eye(kWidth, kHeight, degrees, 2.5);
    const MergedView view = render_unseen({&camera_}, eye, {.show = UnseenStyle::Show::kExtend});
    int window = 0;
    for_each_shown(view, [&](int x, int y) {
      const Eigen::Vector3d point = shown_point(view, eye, x, y) / 2.5;
      if (!is_window(1.1 * point.x(), 1.1 * point.y())) return;
      ASSERT_EQ(view.origin(x, y), Origin::kExtended);
      ASSERT_TRUE(near_color(view.color(x, y), kSky)) << x << ' ' << y << " at " << degrees;
      ASSERT_NEAR(point.z(), 1, 0.01);
      ++window;
    });
    EXPECT_GT(window, 2000);
  }
}

TEST(BackgroundExtension, APlaneThroughAHoleStaysThatPlane) {
  // A slanted wall with a hole of a hundred pixels in its middle.
  const Surface slanted = plane({0.4, 0.1, 1}, 2.5);
  const Surface with_hole = [slanted](double x, double y) -> std::optional<double> {
    if (std::abs(x) < 0.08 && std::abs(y) < 0.08) return std::nullopt;
    return slanted(x, y);
  };
  Looking camera(kinect_model(), with_hole, plain(kWall));
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  const MergedView view = render_unseen({&camera}, eye, {.show = UnseenStyle::Show::kExtend});
  int extended = 0;
  for (int y = kHeight / 4; y < 3 * kHeight / 4; ++y) {
    for (int x = kWidth / 4; x < 3 * kWidth / 4; ++x) {
      if (view.origin(x, y) != Origin::kExtended) continue;
      const Eigen::Vector3d point = shown_point(view, eye, x, y);
      ASSERT_NEAR(Eigen::Vector3d(0.4, 0.1, 1).dot(point), 2.5, 0.03) << x << ' ' << y;
      ++extended;
    }
  }
  EXPECT_GT(extended, 500);
}

TEST(BackgroundExtension, NothingSeenLeavesEverythingEmpty) {
  Looking camera(kinect_model(), [](double, double) { return std::optional<double>(); });
  const MergedView view =
      render_unseen({&camera}, eye_at_origin(kWidth, kHeight), {.show = UnseenStyle::Show::kExtend});
  EXPECT_EQ(share(view, Origin::kEmpty), 1);
  const MergedView none =
      render_unseen({}, eye_at_origin(kWidth, kHeight), {.show = UnseenStyle::Show::kExtend});
  EXPECT_EQ(share(none, Origin::kEmpty), 1);
}

TEST(BackgroundExtension, TakesViewsOfAnySize) {
  Looking camera(kinect_model(), wall(2), plain(kWall));
  for (const auto& [width, height] : {std::pair{16, 16}, {18, 22}, {2, 2}, {6, 130}}) {
    const MergedView view =
        render_unseen({&camera}, orbiting_eye(width, height, 30, 2), {.show = UnseenStyle::Show::kExtend});
    EXPECT_NEAR(share(view, Origin::kSeen) + share(view, Origin::kExtended) + share(view, Origin::kEmpty), 1,
                1e-9);
  }
}

}  // namespace
}  // namespace copresence::renderer
