#include "tools/calibrate/lens/lens_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/aruco/charuco.hpp>
#include <random>

#include "tests/tools/calibrate/painted_board.h"
#include "tools/calibrate/geometry/world_fit.h"
#include "tools/calibrate/lens/still_board.h"

namespace copresence::calibrate {
namespace {

const std::vector<BoardView>& views() {
  static const std::vector<BoardView> kAll = [] {
    const PaintedCamera camera(kLens);
    std::vector<BoardView> found;
    for (const Rigid3& pose : places()) {
      auto view =
          find_board(kBoard, camera.picture({{pose, chessboard}}), "view " + std::to_string(found.size()));
      if (view) found.push_back(std::move(*view));
    }
    return found;
  }();
  return kAll;
}

TEST(Board, IsFoundToAFifthOfAPixel) {
  ASSERT_EQ(views().size(), places().size());
  double squares = 0, count = 0;
  for (std::size_t v = 0; v < views().size(); ++v) {
    const BoardView& view = views()[v];
    ASSERT_EQ(view.pixels.size(), 35u);
    for (std::size_t i = 0; i < view.pixels.size(); ++i, ++count) {
      const Eigen::Vector3d corner(view.on_board[i].x(), view.on_board[i].y(), 0);
      squares += (project(kLens, places()[v] * corner) - view.pixels[i]).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 0.2);
}

TEST(Board, IsNotSeenWhereThereIsNone) {
  EXPECT_FALSE(find_board(kBoard, ColorImage(320, 240), "black"));
  Board charuco = kBoard;
  charuco.kind = Board::Kind::kCharuco;
  charuco.marker_m = 0.02;
  charuco.dictionary = "4x4_50";
  EXPECT_FALSE(find_board(charuco, ColorImage(320, 240), "black"));
}

TEST(Board, ACharucoBoardThatCannotBeIsRefused) {
  Board board{Board::Kind::kCharuco, 8, 6, 0.04, 0.03, "4x4_50"};
  EXPECT_EQ(problem_of(board), "");
  board.columns = board.rows = 20;
  EXPECT_THAT(problem_of(board), ::testing::HasSubstr("has 200 markers, but --dictionary 4x4_50 holds 50"));
  board = {Board::Kind::kCharuco, 8, 6, 0.04, 0.05, "4x4_50"};
  EXPECT_THAT(problem_of(board), ::testing::HasSubstr("smaller than its squares"));
}

TEST(Board, WithMarkersIsFoundInPart) {
  const Board board{Board::Kind::kCharuco, 6, 5, 0.04, 0.03, "4x4_50"};
  const auto charuco =
      cv::aruco::CharucoBoard::create(board.columns, board.rows, float(board.square_m), float(board.marker_m),
                                      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50));
  cv::Mat drawn;
  constexpr double kPerMetre = 2000;
  charuco->draw(cv::Size(int(0.24 * kPerMetre), int(0.20 * kPerMetre)), drawn);
  const auto paint = [&](double x, double y) {
    const int u = int(std::floor(x * kPerMetre)), v = int(std::floor(y * kPerMetre));
    if (u < -40 || v < -40 || u >= drawn.cols + 40 || v >= drawn.rows + 40) return -1;
    if (u < 0 || v < 0 || u >= drawn.cols || v >= drawn.rows) return 235;
    return drawn.at<uchar>(v, u) > 127 ? 235 : 25;
  };
  const CameraModel lens{640, 480, 580, 580, 319.5, 239.5, {}};
  const PaintedCamera camera(lens);
  const Rigid3 straight{Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                        {-0.12, -0.1, 0.5}};
  const auto whole = find_board(board, camera.picture({{straight, paint}}), "whole");
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->pixels.size(), 20u);
  const Rigid3 cut{Eigen::Matrix3d::Identity(), {-0.32, -0.1, 0.45}};
  const auto part = find_board(board, camera.picture({{cut, paint}}), "part");
  ASSERT_TRUE(part);
  EXPECT_LT(part->pixels.size(), 20u);
}

TEST(Board, LeavesOutWhatIsBlurredOrAlreadyThere) {
  std::vector<BoardView> many = views();
  BoardView blurred = many[1], again = many[2];
  blurred.picture = "blurred";
  blurred.sharpness = 0.1 * many[1].sharpness;
  again.picture = "again";
  for (auto& pixel : again.pixels) pixel.x() += 2;
  many.push_back(blurred);
  many.push_back(again);
  std::vector<DroppedView> dropped;
  const auto kept = worth_using(many, 320, dropped);
  EXPECT_GE(kept.size(), 9u);
  const auto why = [&](const std::string& picture) {
    for (const DroppedView& view : dropped) {
      if (view.picture == picture) return view.why;
    }
    return std::string("kept");
  };
  EXPECT_EQ(why("blurred"), "blurred");
  EXPECT_THAT(why("again"), testing::StartsWith("the same view as view"));
  EXPECT_EQ(why("view 0"), "kept");
}

TEST(LensFit, FindsALensWithDistortion) {
  const auto fit = fit_lens(views(), 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_LT(fit->rms_px, 0.2);
  EXPECT_EQ(fit->views.size(), views().size());
  EXPECT_GT(fit->covered, 0.6);
  // k1 to k6 can stand for one another; what counts is where points appear.
  double most = 0;
  for (int y = 60; y <= 180; y += 20) {
    for (int x = 80; x <= 240; x += 20) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector2d shift = project(fit->model, unproject(kLens, pixel, 1)) - pixel;
      most = std::max(most, shift.norm());
    }
  }
  EXPECT_LT(most, 2.5);
  EXPECT_NEAR(fit->model.fx, kLens.fx, 1.5);
  EXPECT_NEAR(fit->model.cx, kLens.cx, 1.5);
}

std::vector<BoardView> exact_views(const CameraModel& lens, double noise_px) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, noise_px);
  std::vector<BoardView> all = views();
  for (std::size_t v = 0; v < all.size(); ++v) {
    for (std::size_t i = 0; i < all[v].pixels.size(); ++i) {
      const Eigen::Vector3d corner(all[v].on_board[i].x(), all[v].on_board[i].y(), 0);
      all[v].pixels[i] = project(lens, places()[v] * corner) + Eigen::Vector2d(noise(random), noise(random));
    }
  }
  return all;
}

// Over the whole picture, also where no corner was.
double most_off(const CameraModel& found, const CameraModel& truth) {
  double most = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      const Eigen::Vector2d pixel(x, y);
      most = std::max(most, (project(found, unproject(truth, pixel, 1)) - pixel).norm());
    }
  }
  return most;
}

TEST(LensFit, MakesUpNoDistortionForALensThatHasNone) {
  CameraModel straight = kLens;
  straight.distortion = {};
  const auto fit = fit_lens(exact_views(straight, 0.1), 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_EQ(fit->distortion, "none");
  EXPECT_FALSE(fit->model.is_distorted());
  EXPECT_LT(most_off(fit->model, straight), 1.5);
}

TEST(LensFit, FitsAllCoefficientsWhereALensNeedsThem) {
  CameraModel wide = kLens;
  wide.fx = wide.fy = 200;
  wide.distortion = {0.9, 0.1, 0.0008, -0.0005, 0, 1.1, 0.2, 0.01};
  ASSERT_TRUE(check(wide));
  const auto fit = fit_lens(exact_views(wide, 0.02), 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_NE(fit->distortion, "none");
  EXPECT_LT(fit->rms_px, 0.04);
  EXPECT_TRUE(check(fit->model));
}

TEST(LensFit, LeavesOutAViewThatDoesNotFit) {
  std::vector<BoardView> some = views();
  for (std::size_t i = 0; i < some[4].pixels.size(); i += 2) some[4].pixels[i].y() += 3;
  const auto fit = fit_lens(some, 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  ASSERT_EQ(fit->dropped.size(), 1u);
  EXPECT_EQ(fit->dropped[0].picture, "view 4");
  EXPECT_LT(fit->rms_px, 0.2);
}

TEST(LensFit, AsksForMoreViews) {
  const auto fit = fit_lens(std::span(views()).first(3), 320, 240);
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().what, testing::HasSubstr("only 3 different, sharp views"));
}

TEST(LocateBoard, FindsTwoCamerasFromOneBoard) {
  // Thesis 2.5.2: both see the board; what lies between them follows.
  const PaintedCamera camera(kLens);
  const Rigid3 a_from_board = place(0.03, 0, 0.4, 0.1, 0.3),
               b_from_board = place(-0.04, 0.02, 0.42, 0.0, -0.3);
  const auto in_a =
      locate_board(*find_board(kBoard, camera.picture({{a_from_board, chessboard}}), "a"), kLens);
  const auto in_b =
      locate_board(*find_board(kBoard, camera.picture({{b_from_board, chessboard}}), "b"), kLens);
  ASSERT_TRUE(in_a && in_b);
  EXPECT_LT(in_a->rms_px, 0.3);
  const Rigid3 a_from_b = in_a->camera_from_board * in_b->camera_from_board.inverse();
  const Rigid3 off = a_from_b * (a_from_board * b_from_board.inverse()).inverse();
  EXPECT_LT((off * Eigen::Vector3d(0, 0, 0.4) - Eigen::Vector3d(0, 0, 0.4)).norm(), 0.002);
}

TEST(StillBoard, JoinsTwoCamerasAsMarkersDo) {
  const PaintedCamera camera(kLens);
  const Rigid3 a_from_board = place(0.03, 0, 0.4, 0.1, 0.3),
               b_from_board = place(-0.04, 0.02, 0.42, 0.0, -0.3);
  std::vector<calibration::Sighting> sightings;
  for (const auto& [number, pose] : {std::pair{0, a_from_board}, std::pair{1, b_from_board}}) {
    const std::vector<ColorImage> pictures(2, camera.picture({{pose, chessboard}}));
    const auto board = find_still_board(kBoard, pictures, kLens);
    ASSERT_TRUE(board) << board.error().what;
    for (const auto& sighting : sightings_of(std::size_t(number), *board, kLens))
      sightings.push_back(sighting);
  }
  calibration::Names names{{"a", "b"}, {}};
  for (int i = 0; i < 35; ++i) names.markers.push_back(std::to_string(i));
  const auto fit = calibration::fit_world(sightings, names, {0, {}, calibration::Form::kRigid, true});
  ASSERT_TRUE(fit) << fit.error().what;
  const Rigid3 off = fit->cameras[1].world_from_camera * (a_from_board * b_from_board.inverse()).inverse();
  EXPECT_LT((off * Eigen::Vector3d(0, 0, 0.4) - Eigen::Vector3d(0, 0, 0.4)).norm(), 0.002);
  EXPECT_LT(fit->cameras[1].leave_one_out.rms, 0.004);
}

TEST(StillBoard, RefusesABoardThatMoves) {
  const PaintedCamera camera(kLens);
  const std::vector<ColorImage> pictures{camera.picture({{place(0.03, 0, 0.4, 0.1, 0.3), chessboard}}),
                                         camera.picture({{place(0.02, 0, 0.4, 0.1, 0.3), chessboard}})};
  EXPECT_THAT(find_still_board(kBoard, pictures, kLens).error().what, testing::HasSubstr("moved"));
  const std::vector<ColorImage> none(1, ColorImage(320, 240));
  EXPECT_EQ(find_still_board(kBoard, none, kLens).error().code, ErrorCode::kNotFound);
}

TEST(BoardSize, IsColumnsTimesRows) {
  Board board;
  EXPECT_EQ(parse_board_size("7x11", board), "");
  EXPECT_EQ(board.columns, 7);
  EXPECT_EQ(board.rows, 11);
  for (const char* wrong : {"", "7", "x", "7x", "7x2", "41x5", "7x5x", "-7x5", "ax5"}) {
    EXPECT_NE(parse_board_size(wrong, board), "") << wrong;
  }
}

}  // namespace
}  // namespace copresence::calibrate
