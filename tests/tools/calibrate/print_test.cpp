// Tests of printed boards and markers: reads the PDF file back, draws it, and measures what it
// shows.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "tools/calibrate/markers/dictionary.h"
#include "tools/calibrate/markers/marker_finder.h"
#include "tools/calibrate/print/sheet.h"

namespace copresence::calibrate {
namespace {

using ::testing::HasSubstr;

constexpr double kPixelsPerMm = 5;
constexpr double kPointsPerMm = 72 / 25.4;

struct ReadPage {
  double width_mm = 0, height_mm = 0;
  ColorImage picture;
};

// Paints the rectangles ("x y width height re") of each page between "stream" and "endstream".
std::vector<ReadPage> read_pdf(const std::string& pdf) {
  std::vector<ReadPage> pages;
  std::istringstream lines(pdf);
  ReadPage page;
  cv::Mat gray;
  double scale = 0;
  for (std::string line; std::getline(lines, line);) {
    if (const auto box = line.find("/MediaBox [0 0 "); box != std::string::npos) {
      std::istringstream(line.substr(box + 15)) >> page.width_mm >> page.height_mm;
      page.width_mm /= kPointsPerMm;
      page.height_mm /= kPointsPerMm;
      gray = cv::Mat(int(page.height_mm * kPixelsPerMm), int(page.width_mm * kPixelsPerMm), CV_8UC1,
                     cv::Scalar(255));
    }
    if (line.ends_with(" cm")) {
      std::istringstream(line) >> scale;
      EXPECT_NEAR(scale, kPointsPerMm, 1e-8);
    }
    if (line.ends_with(" re")) {
      std::array<double, 4> r{};
      std::istringstream numbers(line);
      for (double& number : r) numbers >> number;
      EXPECT_GE(r[0], 0);
      EXPECT_LE(r[0] + r[2], page.width_mm);
      EXPECT_GE(r[1], 0);
      EXPECT_LE(r[1] + r[3], page.height_mm);
      const auto pixel = [](double mm) { return int(std::lround(mm * kPixelsPerMm)); };
      const cv::Point low(pixel(r[0]), pixel(page.height_mm - r[1] - r[3])),
          high(pixel(r[0] + r[2]), pixel(page.height_mm - r[1]));
      gray(cv::Rect(low, high) & cv::Rect(0, 0, gray.cols, gray.rows)).setTo(0);
    }
    if (line == "endstream") {
      page.picture = ColorImage(gray.cols, gray.rows);
      cv::Mat rgb(gray.rows, gray.cols, CV_8UC3, page.picture.data());
      cv::cvtColor(gray, rgb, cv::COLOR_GRAY2RGB);
      pages.push_back(std::move(page));
      page = {};
    }
  }
  return pages;
}

// Checks that every object is at its offset in the cross-reference table.
void expect_sound(const std::string& pdf) {
  EXPECT_TRUE(pdf.starts_with("%PDF-1.4\n"));
  EXPECT_TRUE(pdf.ends_with("%%EOF\n"));
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref\n") + 10));
  std::istringstream lines(pdf.substr(table));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "xref");
  int first = 0, count = 0;
  lines >> first >> count;
  std::getline(lines, line);
  std::getline(lines, line);  // object 0
  for (int object = 1; object < count; ++object) {
    std::getline(lines, line);
    EXPECT_EQ(line.size(), 19u);
    const std::string expected = std::to_string(object) + " 0 obj";
    EXPECT_EQ(pdf.substr(std::stoul(line.substr(0, 10)), expected.size()), expected);
  }
}

TEST(Print, MakesAChessboardOfExactMillimetres) {
  for (const Paper& paper : {kA4, kA3}) {
    Board board{Board::Kind::kChessboard, 9, 6, 0, 0, "4x4_50"};
    const auto sheet = board_sheet(board, paper);
    ASSERT_TRUE(sheet) << sheet.error().what;
    const std::string pdf = to_pdf(*sheet);
    expect_sound(pdf);
    const double square = paper.name == "A4" ? 25 : 37;
    EXPECT_EQ(sheet->flags, "calibrate intrinsics --images FOLDER --board-size 9x6 --square " +
                                std::to_string(int(square)));
    EXPECT_THAT(pdf, HasSubstr(sheet->flags));
    const auto pages = read_pdf(pdf);
    ASSERT_EQ(pages.size(), 1u);
    EXPECT_NEAR(pages[0].width_mm, paper.longer_mm, 0.01);
    EXPECT_NEAR(pages[0].height_mm, paper.shorter_mm, 0.01);
    const auto view = find_board(board, pages[0].picture, "print");
    ASSERT_TRUE(view) << paper.name;
    EXPECT_NEAR((view->pixels[8] - view->pixels[0]).norm() / kPixelsPerMm, 8 * square, 0.1);
    EXPECT_NEAR((view->pixels[45] - view->pixels[0]).norm() / kPixelsPerMm, 5 * square, 0.1);
  }
}

TEST(Print, MakesACharucoBoard) {
  for (const int rows : {5, 6}) {
    Board board{Board::Kind::kCharuco, 8, rows, 0.028, 0.020, "5x5_100"};
    const auto sheet = board_sheet(board, kA4);
    ASSERT_TRUE(sheet) << sheet.error().what;
    EXPECT_THAT(sheet->flags, HasSubstr("--square 28 --marker 20 --dictionary 5x5_100"));
    const auto pages = read_pdf(to_pdf(*sheet));
    ASSERT_EQ(pages.size(), 1u);
    const auto view = find_board(board, pages[0].picture, "print");
    ASSERT_TRUE(view);
    EXPECT_EQ(view->pixels.size(), static_cast<std::size_t>(7 * (rows - 1)));
    EXPECT_EQ(view->layout, CharucoLayout::kBlackCorner);
    EXPECT_NEAR((view->pixels[6] - view->pixels[0]).norm() / kPixelsPerMm, 6 * 28, 0.1);
  }
}

TEST(Print, MakesOneMarkerPerPage) {
  for (const int border_bits : {1, 2}) {
    const std::array numbers{3, 0, 17};
    const auto sheet = marker_sheet("apriltag_36h11", border_bits, numbers, 0.12, kA4);
    ASSERT_TRUE(sheet) << sheet.error().what;
    const std::string pdf = to_pdf(*sheet);
    expect_sound(pdf);
    const auto pages = read_pdf(pdf);
    ASSERT_EQ(pages.size(), 3u);
    for (std::size_t i = 0; i < pages.size(); ++i) {
      auto finder = MarkerFinder::open("apriltag_36h11", border_bits);
      ASSERT_TRUE(finder);
      finder->add(pages[i].picture);
      const CameraModel straight{
          pages[i].picture.width(), pages[i].picture.height(), 1000, 1000, 500, 500, {}};
      const auto found = finder->found(straight);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].name, std::to_string(numbers[i]));
      const auto seen = find_dictionary(pages[i].picture);
      ASSERT_TRUE(seen);
      EXPECT_EQ(seen->name, "apriltag_36h11");
      EXPECT_EQ(seen->border_bits, border_bits);
      EXPECT_NEAR((found[0].corners[1] - found[0].corners[0]).norm() / kPixelsPerMm, 120, 0.2);
      EXPECT_NEAR((found[0].corners[2] - found[0].corners[1]).norm() / kPixelsPerMm, 120, 0.2);
    }
  }
}

TEST(Dictionaries, AreKnownByTheNamesOfOpenCvAndAprilTag) {
  EXPECT_EQ(canonical_dictionary("4x4_50"), "4x4_50");
  EXPECT_EQ(canonical_dictionary("DICT_4X4_1000"), "4x4_1000");
  EXPECT_EQ(canonical_dictionary("DICT_ARUCO_ORIGINAL"), "original");
  EXPECT_EQ(canonical_dictionary("tag36h11"), "apriltag_36h11");
  EXPECT_EQ(canonical_dictionary("DICT_APRILTAG_16h5"), "apriltag_16h5");
  EXPECT_EQ(canonical_dictionary("AprilTag 25h9"), "apriltag_25h9");
  EXPECT_FALSE(canonical_dictionary("tagStandard41h12"));
  for (const std::string& name : marker_dictionaries()) EXPECT_EQ(canonical_dictionary(name), name);
  EXPECT_FALSE(find_dictionary(ColorImage(320, 240)));
}

TEST(Print, SaysWhatFits) {
  EXPECT_THAT(board_sheet({Board::Kind::kChessboard, 9, 6, 0.030, 0, "4x4_50"}, kA4).error().what,
              HasSubstr("do not fit on A4: give --square 25 or less"));
  const std::array beyond{50}, first{0};
  EXPECT_THAT(marker_sheet("4x4_50", 1, beyond, 0, kA4).error().what, HasSubstr("its numbers are 0 to 49"));
  EXPECT_THAT(marker_sheet("4x4_50", 1, first, 0.3, kA4).error().what,
              HasSubstr("give --marker 157 or less"));
}

}  // namespace
}  // namespace copresence::calibrate
