#include "tools/calibrate/intrinsics/intrinsics_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/tools/calibrate/painted_board.h"
#include "tools/calibrate/geometry/world_fit.h"
#include "tools/calibrate/intrinsics/still_board.h"
#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

const std::vector<BoardView>& views() {
  static const std::vector<BoardView> kAll = [] {
    const PaintedCamera camera(kIntrinsics);
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
      squares += (project(kIntrinsics, places()[v] * corner) - view.pixels[i]).squaredNorm();
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
  constexpr double kPerMetre = 2000;
  const cv::Size size(int(0.24 * kPerMetre), int(0.20 * kPerMetre));
  const auto square = float(board.square_m), marker = float(board.marker_m);
  cv::Mat drawn;  // Drawn by OpenCV, to test that its boards are found.
#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 407
  cv::aruco::CharucoBoard(cv::Size(board.columns, board.rows), square, marker, *make_dictionary("4x4_50"))
      .generateImage(size, drawn);
#else
  cv::aruco::CharucoBoard::create(board.columns, board.rows, square, marker, make_dictionary("4x4_50"))
      ->draw(size, drawn);
#endif
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

// A ChArUco board of 6x6 squares of 40 mm, in the layout of OpenCV before 4.6 (`legacy`) or later.
int charuco_before_4_6(double x, double y, bool legacy) {
  constexpr int kSquares = 6, kCells = 6;
  constexpr double kSquare = 0.04, kMarker = 0.03;
  const int column = int(std::floor(x / kSquare)), row = int(std::floor(y / kSquare));
  if (column < -1 || row < -1 || column > kSquares || row > kSquares) return -1;
  if (column < 0 || row < 0 || column >= kSquares || row >= kSquares) return 235;
  const bool is_black = ((row + column) % 2 == 0) != legacy;
  if (is_black) return 25;
  const double u = (x - column * kSquare - (kSquare - kMarker) / 2) / kMarker * kCells,
               v = (y - row * kSquare - (kSquare - kMarker) / 2) / kMarker * kCells;
  if (u < 0 || v < 0 || u >= kCells || v >= kCells) return 235;
  const int number = (row * kSquares + column) / 2;  // Row by row, three in each.
  const cv::Mat bits = marker_cells("4x4_50", number, 1);
  return bits.at<uchar>(int(v), int(u)) > 127 ? 235 : 25;
}

TEST(Board, OfOpenCvBefore46IsRecognisedByItsMarkers) {
  const Board board{Board::Kind::kCharuco, 6, 6, 0.04, 0.03, "4x4_50"};
  const CameraModel lens{640, 480, 580, 580, 319.5, 239.5, {}};
  const Rigid3 pose{Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix(), {-0.12, -0.12, 0.5}};
  for (const bool legacy : {false, true}) {
    const auto paint = [legacy](double x, double y) { return charuco_before_4_6(x, y, legacy); };
    const auto view = find_board(board, PaintedCamera(lens).picture({{pose, paint}}), "board");
    ASSERT_TRUE(view) << legacy;
    EXPECT_EQ(view->layout, legacy ? CharucoLayout::kMarkerCorner : CharucoLayout::kBlackCorner);
    EXPECT_EQ(view->pixels.size(), 25u);
    for (std::size_t i = 0; i < view->pixels.size(); ++i) {
      // Positions on the board begin at the first inner corner, one square from the board's own
      // corner.
      const Eigen::Vector3d corner(view->on_board[i].x() + 0.04, view->on_board[i].y() + 0.04, 0);
      EXPECT_LT((project(lens, pose * corner) - view->pixels[i]).norm(), 0.4) << legacy << ' ' << i;
    }
  }
}

TEST(Board, OfAnotherSizeOrDictionaryIsNamed) {
  const PaintedCamera camera(kIntrinsics);
  const ColorImage chessboard_picture = camera.picture({{places()[0], chessboard}});
  Board squares = kBoard;  // 7x5 inner corners
  squares.columns = 8;
  squares.rows = 6;
  EXPECT_FALSE(find_board(squares, chessboard_picture, "board"));
  EXPECT_THAT(describe_other_board(squares, chessboard_picture), testing::HasSubstr("--board-size 7x5"));
  EXPECT_THAT(describe_other_board(squares, chessboard_picture),
              testing::HasSubstr("one inner corner less than squares"));
  EXPECT_EQ(describe_other_board(kBoard, ColorImage(320, 240)), "");

  const CameraModel lens{640, 480, 580, 580, 319.5, 239.5, {}};
  const Rigid3 pose{Eigen::Matrix3d::Identity(), {-0.12, -0.12, 0.5}};
  const ColorImage charuco = PaintedCamera(lens).picture(
      {{pose, [](double x, double y) { return charuco_before_4_6(x, y, false); }}});
  EXPECT_THAT(describe_other_board({Board::Kind::kCharuco, 5, 5, 0.04, 0.03, "4x4_50"}, charuco),
              testing::HasSubstr("--board-size 6x6"));
  EXPECT_THAT(describe_other_board({Board::Kind::kCharuco, 6, 6, 0.04, 0.03, "5x5_100"}, charuco),
              testing::HasSubstr("18 markers of 4x4_50: give --dictionary 4x4_50"));
}

// A rotated 9x6 board with squares of `square_px` pixels in front of a rough wall, with the noise
// of a small sensor.
ColorImage photograph(int width, int height, double square_px, cv::Point2f at,
                      std::vector<cv::Point2f>& corners) {
  constexpr int kScale = 10, kColumns = 10, kRows = 7;
  cv::Mat board((kRows + 2) * kScale, (kColumns + 2) * kScale, CV_8UC1, cv::Scalar(235));
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      if ((row + column) % 2 != 0) continue;
      board(cv::Rect((column + 1) * kScale, (row + 1) * kScale, kScale, kScale)).setTo(25);
    }
  }
  cv::Mat big;
  cv::resize(board, big, {}, square_px / kScale, square_px / kScale, cv::INTER_NEAREST);
  cv::Mat rough(height / 8, width / 8, CV_8UC1), gray;
  cv::randu(rough, 60, 180);
  cv::resize(rough, gray, cv::Size(width, height), 0, 0, cv::INTER_LINEAR);
  const double turn = 0.1;
  const cv::Matx23d place(std::cos(turn), -std::sin(turn), at.x, std::sin(turn), std::cos(turn), at.y);
  cv::warpAffine(big, gray, place, gray.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
  cv::Mat noise(gray.size(), CV_16SC1), noisy;
  cv::randn(noise, 0, 6);
  gray.convertTo(noisy, CV_16S);
  noisy += noise;
  noisy.convertTo(gray, CV_8U);
  corners.clear();
  for (int row = 1; row < kRows; ++row) {
    for (int column = 1; column < kColumns; ++column) {
      const double x = (column + 1) * square_px - 0.5, y = (row + 1) * square_px - 0.5;
      corners.emplace_back(float(place(0, 0) * x + place(0, 1) * y + place(0, 2)),
                           float(place(1, 0) * x + place(1, 1) * y + place(1, 2)));
    }
  }
  ColorImage picture(width, height);
  cv::Mat rgb(height, width, CV_8UC3, picture.data());
  cv::cvtColor(gray, rgb, cv::COLOR_GRAY2RGB);
  return picture;
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

TEST(Board, IsFoundInAPhotographOf12MegapixelsNearAndFar) {
  const Board board{Board::Kind::kChessboard, 9, 6, 0.025, 0, ""};
  for (const double square : {180.0, 50.0}) {
    std::vector<cv::Point2f> truth;
    const ColorImage picture = photograph(4032, 3024, square, {900, 500}, truth);
    const double start = processor_seconds();
    const auto view = find_board(board, picture, "photograph");
    EXPECT_LT(processor_seconds() - start, 15) << "a search of the full picture takes minutes";
    ASSERT_TRUE(view) << square;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_LT((view->pixels[i] - Eigen::Vector2d(truth[i].x, truth[i].y)).norm(), 0.5)
          << square << ' ' << i;
    }
  }
}

TEST(Board, CutByThePicturesRimIsGivenUpSoon) {
  const Board board{Board::Kind::kChessboard, 9, 6, 0.025, 0, ""};
  for (const auto& [width, height] : {std::pair{1920, 1080}, std::pair{640, 480}}) {
    std::vector<cv::Point2f> truth;
    const ColorImage picture =
        photograph(width, height, height / 8.0, {0.1f * float(width), -0.3f * float(height)}, truth);
    const double start = processor_seconds();
    EXPECT_FALSE(find_board(board, picture, "cut"));
    EXPECT_LT(processor_seconds() - start, 15);
  }
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
  const auto kept = select_views(many, 320, dropped);
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

TEST(IntrinsicsFit, FindsALensWithDistortion) {
  const auto fit = fit_intrinsics(views(), 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_LT(fit->rms_px, 0.2);
  EXPECT_EQ(fit->views.size(), views().size());
  EXPECT_GT(fit->covered, 0.6);
  // Different k1 to k6 can be nearly the same distortion, so the positions of points are compared.
  double most = 0;
  for (int y = 60; y <= 180; y += 20) {
    for (int x = 80; x <= 240; x += 20) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector2d shift = project(fit->model, unproject(kIntrinsics, pixel, 1)) - pixel;
      most = std::max(most, shift.norm());
    }
  }
  EXPECT_LT(most, 2.5);
  EXPECT_NEAR(fit->model.fx, kIntrinsics.fx, 1.5);
  EXPECT_NEAR(fit->model.cx, kIntrinsics.cx, 1.5);
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

// The largest error over the whole picture, also where there are no corners.
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

TEST(IntrinsicsFit, MakesUpNoDistortionForALensThatHasNone) {
  CameraModel straight = kIntrinsics;
  straight.distortion = {};
  const auto fit = fit_intrinsics(exact_views(straight, 0.1), 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_EQ(fit->distortion, "none");
  EXPECT_FALSE(fit->model.is_distorted());
  EXPECT_LT(most_off(fit->model, straight), 1.5);
}

TEST(IntrinsicsFit, FitsAllCoefficientsWhereALensNeedsThem) {
  CameraModel wide = kIntrinsics;
  wide.fx = wide.fy = 200;
  wide.distortion = {0.9, 0.1, 0.0008, -0.0005, 0, 1.1, 0.2, 0.01};
  ASSERT_TRUE(check(wide));
  const auto fit = fit_intrinsics(exact_views(wide, 0.02), 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_NE(fit->distortion, "none");
  EXPECT_LT(fit->rms_px, 0.04);
  EXPECT_TRUE(check(fit->model));
}

TEST(IntrinsicsFit, LeavesOutAViewThatDoesNotFit) {
  std::vector<BoardView> some = views();
  for (std::size_t i = 0; i < some[4].pixels.size(); i += 2) some[4].pixels[i].y() += 3;
  const auto fit = fit_intrinsics(some, 320, 240);
  ASSERT_TRUE(fit) << fit.error().what;
  ASSERT_EQ(fit->dropped.size(), 1u);
  EXPECT_EQ(fit->dropped[0].picture, "view 4");
  EXPECT_LT(fit->rms_px, 0.2);
}

TEST(IntrinsicsFit, AsksForMoreViews) {
  const auto fit = fit_intrinsics(std::span(views()).first(3), 320, 240);
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().what, testing::HasSubstr("only 3 different, sharp views"));
}

TEST(IntrinsicsFit, TakesAWideLens) {
  CameraModel wide{640, 480, 275, 275, 320, 240, {-0.28, 0.06, 0, 0, 0, 0, 0, 0}};
  const auto fit = fit_intrinsics(exact_views(wide, 0.05), 640, 480);
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_NEAR(fit->model.fx, 275, 1);
  EXPECT_LT(fit->rms_px, 0.1);
  EXPECT_LT(times_good_rms(*fit), 1);
}

std::string refusal(const std::vector<BoardView>& all, int width, int height) {
  const auto fit = fit_intrinsics(all, width, height);
  return fit ? "accepted" : fit.error().what;
}

TEST(IntrinsicsFit, RefusesPicturesOfTwoCameras) {
  CameraModel a{640, 480, 580, 583, 322, 236, {0.12, -0.2, 0.0012, -0.0009, 0, 0, 0, 0}}, b = a;
  b.fx = b.fy = 440;
  b.cx = 300;
  std::vector<BoardView> all = exact_views(a, 0.1);
  const std::vector<BoardView> others = exact_views(b, 0.1);
  for (std::size_t i = 0; i < 5; ++i) all[2 * i] = others[2 * i];
  const std::string why = refusal(all, 640, 480);
  EXPECT_THAT(why, testing::HasSubstr("they seem to be of two cameras"));
  EXPECT_THAT(why, testing::HasSubstr("view 0"));
}

TEST(IntrinsicsFit, RefusesViewsThatAreHardlyTilted) {
  std::vector<BoardView> all = exact_views(kIntrinsics, 0.1);
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.1);
  for (std::size_t v = 0; v < all.size(); ++v) {
    const Rigid3 pose =
        place(0.04 * (double(v % 3) - 1), 0.03 * (double(v / 3) - 1), 0.36 + 0.02 * double(v % 4), 0, 0);
    for (std::size_t i = 0; i < all[v].pixels.size(); ++i) {
      const Eigen::Vector3d corner(all[v].on_board[i].x(), all[v].on_board[i].y(), 0);
      all[v].pixels[i] = project(kIntrinsics, pose * corner) + Eigen::Vector2d(noise(random), noise(random));
    }
  }
  EXPECT_THAT(refusal(all, 320, 240), testing::HasSubstr("tilt it by 30 to 45 degrees"));
}

TEST(IntrinsicsFit, RefusesABoardThatIsNotAsGiven) {
  std::vector<BoardView> all = exact_views(kIntrinsics, 0.1);
  for (BoardView& view : all) {
    for (auto& corner : view.on_board) corner.x() += 0.25 * corner.y();  // The squares become parallelograms.
  }
  const std::string why = refusal(all, 320, 240);
  EXPECT_THAT(why, testing::HasSubstr("do not fit one camera"));
  EXPECT_THAT(why, testing::HasSubstr("is the board's size as given"));
}

TEST(IntrinsicsFit, RefusesASizeThatNoCameraModelCanHaveByItsSize) {
  EXPECT_THAT(refusal(views(), 321, 240), testing::HasSubstr("321x240"));
}

TEST(LocateBoard, FindsTwoCamerasFromOneBoard) {
  // Thesis 2.5.2: both cameras see the board, which gives the pose between them.
  const PaintedCamera camera(kIntrinsics);
  const Rigid3 a_from_board = place(0.03, 0, 0.4, 0.1, 0.3),
               b_from_board = place(-0.04, 0.02, 0.42, 0.0, -0.3);
  const auto in_a =
      locate_board(*find_board(kBoard, camera.picture({{a_from_board, chessboard}}), "a"), kIntrinsics);
  const auto in_b =
      locate_board(*find_board(kBoard, camera.picture({{b_from_board, chessboard}}), "b"), kIntrinsics);
  ASSERT_TRUE(in_a && in_b);
  EXPECT_LT(in_a->rms_px, 0.3);
  const Rigid3 a_from_b = in_a->camera_from_board * in_b->camera_from_board.inverse();
  const Rigid3 off = a_from_b * (a_from_board * b_from_board.inverse()).inverse();
  EXPECT_LT((off * Eigen::Vector3d(0, 0, 0.4) - Eigen::Vector3d(0, 0, 0.4)).norm(), 0.002);
}

TEST(StillBoard, JoinsTwoCamerasAsMarkersDo) {
  const PaintedCamera camera(kIntrinsics);
  const Rigid3 a_from_board = place(0.03, 0, 0.4, 0.1, 0.3),
               b_from_board = place(-0.04, 0.02, 0.42, 0.0, -0.3);
  std::vector<Observation> observations;
  for (const auto& [number, pose] : {std::pair{0, a_from_board}, std::pair{1, b_from_board}}) {
    const std::vector<ColorImage> pictures(2, camera.picture({{pose, chessboard}}));
    const auto board = find_still_board(kBoard, pictures, kIntrinsics);
    ASSERT_TRUE(board) << board.error().what;
    for (const auto& observation : observations_of(std::size_t(number), *board, kIntrinsics))
      observations.push_back(observation);
  }
  RigNames names{{"a", "b"}, {}};
  for (int i = 0; i < 35; ++i) names.markers.push_back(std::to_string(i));
  const auto fit = fit_world(observations, names, {0, {}, Solver::kRigid, true});
  ASSERT_TRUE(fit) << fit.error().what;
  const Rigid3 off = fit->cameras[1].world_from_camera * (a_from_board * b_from_board.inverse()).inverse();
  EXPECT_LT((off * Eigen::Vector3d(0, 0, 0.4) - Eigen::Vector3d(0, 0, 0.4)).norm(), 0.002);
  EXPECT_LT(fit->cameras[1].leave_one_out.rms, 0.004);
}

TEST(StillBoard, RefusesABoardThatMoves) {
  const PaintedCamera camera(kIntrinsics);
  const std::vector<ColorImage> pictures{camera.picture({{place(0.03, 0, 0.4, 0.1, 0.3), chessboard}}),
                                         camera.picture({{place(0.02, 0, 0.4, 0.1, 0.3), chessboard}})};
  EXPECT_THAT(find_still_board(kBoard, pictures, kIntrinsics).error().what, testing::HasSubstr("moved"));
  const std::vector<ColorImage> none(1, ColorImage(320, 240));
  EXPECT_EQ(find_still_board(kBoard, none, kIntrinsics).error().code, ErrorCode::kNotFound);
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
