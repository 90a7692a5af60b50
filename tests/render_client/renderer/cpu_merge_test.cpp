// Tests the merge of the surfaces of several cameras (thesis 2.6.1).

#include <gtest/gtest.h>

#include "common/executor.h"
#include "render_client/renderer/merge_rules.h"
#include "tests/render_client/renderer/rendering.h"

namespace copresence::renderer {
namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr Rgb8 kRed = {220, 30, 30}, kGreen = {30, 220, 30};

Rigid3 moved(double x, double y, double z) {
  return {Eigen::Matrix3d::Identity(), {x, y, z}};
}

TEST(CpuMerge, ShowsTheBetterQualityWhereSurfacesAgree) {
  // Both cameras see one wall, at 3 m and at 1.5 m. The wall of the first camera is 1 cm in front.
  Looking far_away(kinect_model(), wall(2.99), plain(kRed));
  Looking close(kinect_model(), wall(1.5), plain(kGreen), moved(0, 0, 1.5));
  for (const auto& order : {std::vector<Looking*>{&far_away, &close}, {&close, &far_away}}) {
    const MergedView view = render(order, eye_at_origin(kWidth, kHeight));
    const int x = kWidth / 2, y = kHeight / 2;
    EXPECT_TRUE(near_color(view.color(x, y), kGreen));
    EXPECT_EQ(order[view.camera(x, y)], &close);
    EXPECT_NEAR(view.depth_m(x, y), 3, 1e-3);
    EXPECT_NEAR(view.quality(x, y), 1 / (1.5 * 1.5), 0.005);
  }
}

MergedView render_merged(const std::vector<Looking*>& cameras, MergeMode mode) {
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  renderer->set_merge(mode);
  MergedView view;
  EXPECT_TRUE(renderer->render(views_of(cameras), eye_at_origin(kWidth, kHeight),
                               {.color = true, .depth = true}, view));
  return view;
}

TEST(CpuMerge, ShowsTheNearestWhereItIsAskedTo) {
  // As above. The wall of the camera with less quality is 1 cm in front.
  Looking far_away(kinect_model(), wall(2.99), plain(kRed));
  Looking close(kinect_model(), wall(1.5), plain(kGreen), moved(0, 0, 1.5));
  const MergedView nearest = render_merged({&far_away, &close}, MergeMode::kNearest);
  EXPECT_TRUE(near_color(nearest.color(kWidth / 2, kHeight / 2), kRed));
  EXPECT_EQ(nearest.camera(kWidth / 2, kHeight / 2), 0);
  const MergedView best = render_merged({&far_away, &close}, MergeMode::kBest);
  EXPECT_TRUE(near_color(best.color(kWidth / 2, kHeight / 2), kGreen));
}

TEST(CpuMerge, BlendsSimilarQualityUnlessTheBestAloneIsAskedFor) {
  // The second camera is a little farther away, so its quality is 19 % less.
  Looking close(kinect_model(), wall(1.8), plain(kRed), moved(0, 0, 0.2));
  Looking far_away(kinect_model(), wall(2), plain(kGreen));
  const auto color = [&](MergeMode mode) {
    return render_merged({&close, &far_away}, mode).color(kWidth / 2, kHeight / 2);
  };
  const Rgba8 blended = color(MergeMode::kBlend);
  EXPECT_GT(blended.g, 80);
  EXPECT_GT(blended.r, 100);
  EXPECT_TRUE(near_color(color(MergeMode::kBest), kRed));
}

TEST(CpuMerge, ShowsTheNearerWhereSurfacesDiffer) {
  Looking far_away(kinect_model(), wall(2.5), plain(kRed));
  Looking close(kinect_model(), wall(1.5), plain(kGreen), moved(0, 0, 1.5));
  const MergedView view = render({&far_away, &close}, eye_at_origin(kWidth, kHeight));
  EXPECT_TRUE(near_color(view.color(kWidth / 2, kHeight / 2), kRed));
  EXPECT_EQ(view.camera(kWidth / 2, kHeight / 2), 0);
}

TEST(CpuMerge, AStaleCameraIsShownOnlyWhereNoLiveCameraShowsAnything) {
  // The wall of the stale camera is nearer and has the better quality.
  Looking stale(kinect_model(), wall(1.2), plain(kRed)), live(kinect_model(), wall(3), plain(kGreen));
  for (int y = 0; y < 480; ++y) {
    for (int x = 320; x < 640; ++x) {
      live.frame.depth(x, y) = 0;
      live.frame.state(x, y) = DepthState::kHole;
    }
  }
  stale.view.opacity = 0.5F;
  for (const auto& order : {std::vector<Looking*>{&stale, &live}, {&live, &stale}}) {
    const MergedView view = render(order, eye_at_origin(kWidth, kHeight));
    const int y = kHeight / 2;
    EXPECT_TRUE(near_color(view.color(kWidth / 2 - 60, y), kGreen));
    EXPECT_EQ(order[view.camera(kWidth / 2 - 60, y)], &live);
    EXPECT_TRUE(near_color(view.color(kWidth / 2 + 60, y), {110, 15, 15}));
    EXPECT_EQ(order[view.camera(kWidth / 2 + 60, y)], &stale);
    EXPECT_NEAR(view.depth_m(kWidth / 2 + 60, y), 1.2, 1e-3);
  }
}

TEST(CpuMerge, ARememberedBackgroundIsShownOnlyWhereNoCameraShowsAnything) {
  // The remembered wall is nearer and has the better quality. The right half of the live camera is
  // a hole.
  Looking live(kinect_model(), wall(3), plain(kGreen)), remembered(kinect_model(), wall(1.2), plain(kRed));
  for (int y = 0; y < 480; ++y) {
    for (int x = 320; x < 640; ++x) {
      live.frame.depth(x, y) = 0;
      live.frame.state(x, y) = DepthState::kHole;
    }
  }
  remembered.view.is_remembered = true;
  flow::WorkerPool workers(1, "test");
  const auto renderer = make_cpu_renderer(workers);
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  const int left = kWidth / 2 - 60, right = kWidth / 2 + 60, y = kHeight / 2;
  const auto show = [&](UnseenStyle::Show style) {
    renderer->set_unseen({.show = style});
    MergedView view;
    EXPECT_TRUE(renderer->render(views_of({&live, &remembered}), eye, {.color = true, .depth = true}, view));
    EXPECT_TRUE(near_color(view.color(left, y), kGreen));
    EXPECT_EQ(view.origin(left, y), Origin::kSeen);
    return view;
  };
  const MergedView plain = show(UnseenStyle::Show::kExtend);
  EXPECT_TRUE(near_color(plain.color(right, y), kRed));
  EXPECT_EQ(plain.origin(right, y), Origin::kRemembered);
  EXPECT_EQ(plain.camera(right, y), 1);
  EXPECT_NEAR(plain.depth_m(right, y), 1.2, 1e-3);
  ASSERT_TRUE(plain.shares);
  std::size_t pixels = 0;
  for (const Origin origin : plain.origin.pixels()) pixels += origin == Origin::kRemembered;
  EXPECT_GT(pixels, 0U);
  EXPECT_FLOAT_EQ(plain.shares->remembered, float(pixels) / (kWidth * kHeight));
  EXPECT_TRUE(near_color(show(UnseenStyle::Show::kDim).color(right, y), {110, 15, 15}));
  EXPECT_EQ(show(UnseenStyle::Show::kBlack).origin(right, y), Origin::kEmpty);
}

TEST(CpuMerge, AStaleCameraCoversARememberedBackground) {
  Looking stale(kinect_model(), wall(3), plain(kGreen)), remembered(kinect_model(), wall(1.2), plain(kRed));
  stale.view.opacity = 0.5F;
  remembered.view.is_remembered = true;
  flow::WorkerPool workers(1, "test");
  const auto renderer = make_cpu_renderer(workers);
  renderer->set_unseen({.show = UnseenStyle::Show::kExtend});
  MergedView view;
  ASSERT_TRUE(renderer->render(views_of({&remembered, &stale}), eye_at_origin(kWidth, kHeight),
                               {.color = true}, view));
  EXPECT_TRUE(near_color(view.color(kWidth / 2, kHeight / 2), {15, 110, 15}));
}

TEST(CpuMerge, ACameraThatIsGoneIsNotDrawn) {
  Looking gone(kinect_model(), wall(1.2), plain(kRed)), live(kinect_model(), wall(3), plain(kGreen));
  gone.view.opacity = 0;
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  EXPECT_TRUE(near_color(render({&gone, &live}, eye).color(kWidth / 2, kHeight / 2), kGreen));
  EXPECT_EQ(count_shown(render({&gone}, eye)), 0);
}

TEST(CpuMerge, AStaleCameraWithoutColorFadesToo) {
  Looking gray(kinect_model(), wall(2), std::nullopt);
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  const int live = render({&gray}, eye).color(kWidth / 2, kHeight / 2).r;
  gray.view.opacity = 0.5F;
  EXPECT_NEAR(render({&gray}, eye).color(kWidth / 2, kHeight / 2).r, live / 2, 1);
}

TEST(CpuMerge, WidensTheRangeByTheCalibrationsErrors) {
  // At 3 m and 1.5 m, 8 cm are more than noise explains, but less than noise and 5 cm.
  Looking far_away(kinect_model(), wall(2.92), plain(kRed));
  Looking close(kinect_model(), wall(1.5), plain(kGreen), moved(0, 0, 1.5));
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  EXPECT_GT(0.08, uncertainty_m(2.92F, 0.005F, kKinectV1Noise) + uncertainty_m(1.5F, 0.005F, kKinectV1Noise));
  EXPECT_EQ(render({&far_away, &close}, eye).camera(kWidth / 2, kHeight / 2), 0);
  close.view.calibration_error_m = 0.15;
  EXPECT_EQ(render({&far_away, &close}, eye).camera(kWidth / 2, kHeight / 2), 1);
}

TEST(CpuMerge, BlendsEqualsEvenly) {
  Looking left(kinect_model(), wall(2), plain(kRed), moved(-0.1, 0, 0));
  Looking right(kinect_model(), wall(2), plain(kGreen), moved(0.1, 0, 0));
  const MergedView view = render({&left, &right}, eye_at_origin(kWidth, kHeight));
  EXPECT_TRUE(near_color(view.color(kWidth / 2, kHeight / 2), {125, 125, 30}, 6));
}

// The colours of the pixels beside an edge between red and green.
constexpr int mixed(int own, int other) {
  return own + (other - own) / kSilhouetteDivisor;
}
constexpr Rgb8 kRedSide{mixed(220, 30), mixed(30, 220), 30}, kGreenSide{kRedSide.g, kRedSide.r, 30};

TEST(CpuMerge, SoftensTheOutlineOfWhatStandsBeforeAWall) {
  for (const bool upright : {true, false}) {
    Looking near_red(kinect_model(), wall(1.5), plain(kRed)),
        far_green(kinect_model(), wall(3), plain(kGreen));
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        if (upright ? x < 320 : y < 240) continue;
        near_red.frame.depth(x, y) = 0;
        near_red.frame.state(x, y) = DepthState::kHole;
      }
    }
    for (const bool extends : {true, false}) {
      if (!extends && !upright) continue;  // Columns are softened only while surfaces are extended.
      InlineExecutor workers;
      const auto renderer = make_cpu_renderer(workers);
      renderer->set_unseen({.show = extends ? UnseenStyle::Show::kExtend : UnseenStyle::Show::kBlack});
      MergedView view;
      ASSERT_TRUE(renderer->render(views_of({&near_red, &far_green}), eye_at_origin(kWidth, kHeight),
                                   {.color = true, .depth = true}, view));
      // Along a line across the edge.
      const auto pixel = [&](int i) {
        return upright ? Eigen::Vector2i(i, kHeight / 2) : Eigen::Vector2i(kWidth / 2, i);
      };
      const auto color = [&](int i) { return view.color(pixel(i).x(), pixel(i).y()); };
      int edge = kHeight / 4;
      while (view.depth_m(pixel(edge + 1).x(), pixel(edge + 1).y()) < 2) ++edge;
      EXPECT_TRUE(near_color(color(edge), kRedSide));
      EXPECT_TRUE(near_color(color(edge + 1), kGreenSide));
      EXPECT_TRUE(near_color(color(edge - 1), kRed));
      EXPECT_TRUE(near_color(color(edge + 2), kGreen));
    }
  }
}

TEST(CpuMerge, ChangesFromCameraToCameraWithoutASeam) {
  // Two cameras look at one wall from left and right. Each is better on its own side.
  const Rigid3 from_left = {turned(35), {-1.2, 0, 0}}, from_right = {turned(-35), {1.2, 0, 0}};
  const auto wall_seen_from = [](const Rigid3& pose) {
    const Eigen::Vector3d n = pose.rotation.transpose() * Eigen::Vector3d::UnitZ();
    return plane(n, 2 - pose.translation.z());
  };
  Looking left(kinect_model(), wall_seen_from(from_left), plain(kRed), from_left);
  Looking right(kinect_model(), wall_seen_from(from_right), plain(kGreen), from_right);
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  const MergedView view = render({&left, &right}, eye);
  int largest = 0, total = 0;
  for (int x = kWidth / 4; x < kWidth * 3 / 4; ++x) {
    const Rgba8 here = view.color(x, kHeight / 2), next = view.color(x + 1, kHeight / 2);
    if (here.a == 0 || next.a == 0) continue;
    largest = std::max(largest, std::abs(next.r - here.r));
    total += here.r - next.r;
  }
  EXPECT_GT(std::abs(total), 150);  // The colour changes from one camera's to the other's.
  EXPECT_LE(largest, 12);           // Each change is small.
}

TEST(CpuMerge, PrefersMeasuredPixelsToFilledOnes) {
  Looking filled(kinect_model(), wall(2), plain(kRed));
  Looking measured(kinect_model(), wall(2.2), plain(kGreen), moved(0, 0, -0.2));
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  EXPECT_EQ(render({&filled, &measured}, eye).camera(kWidth / 2, kHeight / 2), 0);
  for (auto& state : filled.frame.state.pixels()) state = DepthState::kFilled;
  EXPECT_EQ(render({&filled, &measured}, eye).camera(kWidth / 2, kHeight / 2), 1);
}

TEST(CpuMerge, KeepsThinThingsInFront) {
  // A stick of 1 cm in front of a wall. The other camera sees only the wall, with better quality.
  const auto stick = [](double x, double) { return std::abs(x) < 0.004 ? std::optional(1.2) : std::nullopt; };
  Looking far_away(kinect_model(), together({wall(3), stick}), plain(kRed));
  Looking close(kinect_model(), wall(1), plain(kGreen), moved(0, 0, 2));
  const MergedView view = render({&far_away, &close}, eye_at_origin(1280, 720));
  EXPECT_NEAR(view.depth_m(640, 360), 1.2, 0.01);
  EXPECT_TRUE(near_color(view.color(640, 360), kRed));
  EXPECT_TRUE(near_color(view.color(700, 360), kGreen));
}

TEST(CpuMerge, FillsOneCamerasHolesFromTheOther) {
  Looking holey(kinect_model(), wall(2), plain(kRed));
  measure_like_a_kinect(holey.frame, 0.2, 9);
  Looking whole(kinect_model(), wall(2.5), plain(kGreen), moved(0, 0, -0.5));
  const MergedView view = render({&holey, &whole}, eye_at_origin(kWidth, kHeight));
  const auto [red, green] = [&] {
    int from_first = 0, from_second = 0;
    for (int y = 40; y < kHeight - 40; ++y) {
      for (int x = 150; x < kWidth - 150; ++x) {
        EXPECT_NE(view.camera(x, y), kNoCamera) << x << ' ' << y;
        ++(view.camera(x, y) == 0 ? from_first : from_second);
      }
    }
    return std::pair(from_first, from_second);
  }();
  EXPECT_GT(red, green);
  EXPECT_GT(green, 5000);
}

// Two cameras of different exposure look at one wall. The picture of the second camera covers half
// of the view.
TEST(CpuMerge, LeavesNoStepAtTheBorderOfACamerasPicture) {
  Looking one(kinect_model(), wall(2), plain({120, 120, 120}));
  Looking other(kinect_model(), wall(2), plain({160, 160, 160}), moved(1.1, 0, 0));
  const MergedView view = render({&one, &other}, eye_at_origin(kWidth, kHeight));
  int changes = 0;
  for (int y = 40; y < kHeight - 40; ++y) {
    for (int x = 100; x + 1 < kWidth - 100; ++x) {
      if (view.camera(x, y) == kNoCamera || view.camera(x + 1, y) == kNoCamera) continue;
      ASSERT_LE(std::abs(view.color(x, y).g - view.color(x + 1, y).g), 4) << x << ' ' << y;
      changes += view.color(x, y).g != view.color(x + 1, y).g;
    }
  }
  EXPECT_GT(changes, 1000) << "the test sees no border";
}

TEST(CpuMerge, GivesTheSamePictureWithAnyNumberOfThreads) {
  Looking one(kinect_model(), together({wall(3), sphere({0, 0, 2}, 0.4)}));
  Looking two(kinect_model(), wall(3.01), plain({200, 100, 50}));
  measure_like_a_kinect(one.frame, 0.05, 1);
  const ViewPose eye = orbiting_eye(kWidth, kHeight, 10, 2);
  const MergedView single = render({&one, &two}, eye, 16, 1);
  for (int threads : {2, 3, 8}) {
    const MergedView several = render({&one, &two}, eye, 16, threads);
    EXPECT_EQ(several.color, single.color);
    EXPECT_EQ(several.depth_m, single.depth_m);
    EXPECT_EQ(several.camera, single.camera);
    EXPECT_EQ(several.quality, single.quality);
  }
}

TEST(CpuMerge, ForgetsACameraThatIsGone) {
  Looking one(kinect_model(), wall(2), plain(kRed)), two(kinect_model(), wall(1), plain(kGreen));
  InlineExecutor workers;
  const auto renderer = make_cpu_renderer(workers);
  const ViewPose eye = eye_at_origin(kWidth, kHeight);
  MergedView view;
  ASSERT_TRUE(renderer->render(views_of({&one, &two}), eye, {.color = true}, view));
  EXPECT_TRUE(near_color(view.color(kWidth / 2, kHeight / 2), kGreen));
  ASSERT_TRUE(renderer->render(views_of({&one}), eye, {.color = true}, view));
  EXPECT_TRUE(near_color(view.color(kWidth / 2, kHeight / 2), kRed));
}

}  // namespace
}  // namespace copresence::renderer
