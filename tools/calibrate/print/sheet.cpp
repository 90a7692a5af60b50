#include "tools/calibrate/print/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>

#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

// Millimetres.
constexpr double kMargin = 8;                   // at the top and the sides; printers leave 3 to 6 white
constexpr double kFooter = 20;                  // at the bottom: ruler and text
constexpr double kGap = 6;                      // white between a board and the rulers
constexpr double kSideRuler = 7;                // width of the upright ruler
constexpr double kAcross = 100, kUpright = 50;  // lengths of the rulers
constexpr double kTextHeight = 3;

// A line of the length to measure, with a tick at every millimetre.
void add_rulers(Page& page, double x, double y, double upright_x, double upright_y) {
  constexpr double kLine = 0.15;
  const auto tick = [](int mm) { return mm % 10 == 0 ? 4.0 : (mm % 5 == 0 ? 2.8 : 1.6); };
  page.black.push_back({x, y, kAcross, kLine});
  for (int mm = 0; mm <= static_cast<int>(kAcross); ++mm) {
    page.black.push_back({x + mm - kLine / 2, y, kLine, tick(mm)});
  }
  page.black.push_back({upright_x, upright_y, kLine, kUpright});
  for (int mm = 0; mm <= static_cast<int>(kUpright); ++mm) {
    page.black.push_back({upright_x, upright_y + mm - kLine / 2, tick(mm), kLine});
  }
  page.texts.push_back({x + kAcross + 1.5, y + 3, kTextHeight, fmt::format("{:g} mm", kAcross)});
  page.texts.push_back({upright_x, upright_y + kUpright + 4, kTextHeight, fmt::format("{:g} mm", kUpright)});
}

void add_text(Page& page, const Sheet& sheet, const std::string& content) {
  const double bottom = sheet.height_mm;
  page.texts.push_back(
      {kMargin, bottom - 9.5, kTextHeight,
       fmt::format("{}. Print at 100 %, without scaling; the rulers must measure {:g} and {:g} mm.", content,
                   kAcross, kUpright)});
  page.texts.push_back({kMargin, bottom - 5.5, kTextHeight, sheet.flags});
}

// Dark cells of a marker, runs of a row in one piece.
void add_marker(Page& page, const std::string& dictionary, int border_bits, int number, double x, double y,
                double side) {
  const auto codes = cv::aruco::getPredefinedDictionary(*dictionary_number(dictionary));
  const int cells = codes->markerSize + 2 * border_bits;
  cv::Mat bits;
  codes->drawMarker(number, cells, bits, border_bits);
  const double cell = side / cells;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells;) {
      int end = column;
      while (end < cells && bits.at<uchar>(row, end) == 0) ++end;
      if (end > column)
        page.black.push_back({x + column * cell, y + row * cell, (end - column) * cell, cell});
      column = std::max(end, column + 1);
    }
  }
}

int size_of(const std::string& dictionary) {
  return cv::aruco::getPredefinedDictionary(*dictionary_number(dictionary))->bytesList.rows;
}

}  // namespace

Result<Sheet> board_sheet(Board board, const Paper& paper) {
  const bool is_chessboard = board.kind == Board::Kind::kChessboard;
  const int columns = board.columns + (is_chessboard ? 1 : 0), rows = board.rows + (is_chessboard ? 1 : 0);
  Sheet sheet;
  sheet.width_mm = columns >= rows ? paper.longer_mm : paper.shorter_mm;
  sheet.height_mm = columns >= rows ? paper.shorter_mm : paper.longer_mm;
  const double free_width = sheet.width_mm - 2 * (kMargin + kSideRuler + kGap),
               free_height = sheet.height_mm - kMargin - kGap - kFooter;
  const double largest = std::floor(std::min(free_width / columns, free_height / rows));
  const double square = board.square_m > 0 ? 1000 * board.square_m : largest;
  if (square * columns > free_width || square * rows > free_height || square < 1) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}x{} squares of {:g} mm do not fit on {}: give --square {:g} or less, a smaller "
                    "--board-size, or larger --paper",
                    columns, rows, square, paper.name, largest));
  }
  const double marker = board.marker_m > 0 ? 1000 * board.marker_m : std::max(1.0, std::floor(0.75 * square));
  board.square_m = 1e-3 * square;
  board.marker_m = 1e-3 * marker;
  if (const std::string problem = problem_of(board); !problem.empty())
    return fail(ErrorCode::kInvalid, problem);

  Page page;
  const double left = (sheet.width_mm - square * columns) / 2,
               top = kMargin + (free_height - square * rows) / 2;
  int number = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x = left + column * square, y = top + row * square;
      if ((row + column) % 2 == 0) {
        page.black.push_back({x, y, square, square});
      } else if (!is_chessboard) {
        const double rim = (square - marker) / 2;
        add_marker(page, board.dictionary, board.border_bits, number++, x + rim, y + rim, marker);
      }
    }
  }
  if (is_chessboard) {
    sheet.content =
        fmt::format("Chessboard, {}x{} inner corners, squares of {:g} mm", board.columns, board.rows, square);
    sheet.flags = fmt::format("--board-size {}x{} --square {:g}", board.columns, board.rows, square);
  } else {
    sheet.content = fmt::format("ChArUco board, {}x{} squares of {:g} mm, markers of {:g} mm ({})",
                                board.columns, board.rows, square, marker, board.dictionary);
    sheet.flags =
        fmt::format("--board charuco --board-size {}x{} --square {:g} --marker {:g} --dictionary {}",
                    board.columns, board.rows, square, marker, board.dictionary);
    if (board.border_bits != 1) sheet.flags += fmt::format(" --border-bits {}", board.border_bits);
  }
  sheet.flags = "calibrate intrinsics --images FOLDER " + sheet.flags;
  add_rulers(page, left, sheet.height_mm - kFooter, kMargin, top);
  add_text(page, sheet, sheet.content);
  sheet.pages.push_back(std::move(page));
  return sheet;
}

Result<Sheet> marker_sheet(const std::string& dictionary, int border_bits, std::span<const int> numbers,
                           double side_m, const Paper& paper) {
  const int cells =
      cv::aruco::getPredefinedDictionary(*dictionary_number(dictionary))->markerSize + 2 * border_bits;
  Sheet sheet;
  sheet.width_mm = paper.shorter_mm;
  sheet.height_mm = paper.longer_mm;
  const double most = sheet.width_mm / (1 + 2.0 / cells);
  const double side = side_m > 0 ? 1000 * side_m : 10 * std::floor(most / 10);
  if (side > most) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "a marker of {:g} mm with its white rim does not fit on {}: give --marker {:g} or less, or "
            "larger --paper",
            side, paper.name, std::floor(most)));
  }
  sheet.content = fmt::format("Marker of {}, {:g} mm wide", dictionary, side);
  sheet.flags = fmt::format("calibrate markers --dictionary {}", dictionary);
  if (border_bits != 1) sheet.flags += fmt::format(" --border-bits {}", border_bits);
  const double left = (sheet.width_mm - side) / 2;  // as white at the top as at the sides
  for (const int number : numbers) {
    if (number < 0 || number >= size_of(dictionary)) {
      return fail(ErrorCode::kInvalid, fmt::format("{} has no marker {}: its numbers are 0 to {}", dictionary,
                                                   number, size_of(dictionary) - 1));
    }
    Page page;
    add_marker(page, dictionary, border_bits, number, left, left, side);
    add_rulers(page, kMargin + 20, sheet.height_mm - kFooter, kMargin,
               sheet.height_mm - kFooter - kUpright - 5);
    add_text(page, sheet, fmt::format("Marker {} of {}, {:g} mm wide", number, dictionary, side));
    sheet.pages.push_back(std::move(page));
  }
  return sheet;
}

}  // namespace copresence::calibrate
