#include "tools/calibrate/print/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

// All lengths are in millimetres.
constexpr double kMargin = 8;   // Margin at the top and the sides; printers need 3 to 6.
constexpr double kFooter = 20;  // Space for ruler and text at the bottom.
constexpr double kGap = 6;
constexpr double kSideRuler = 7;
constexpr double kAcross = 100, kUpright = 50;
constexpr double kTextHeight = 3;

// Adds two rulers, with a tick at every millimetre.
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

// Adds the dark cells of a marker. Adjacent cells of a row become one rectangle.
void add_marker(Page& page, const std::string& dictionary, int border_bits, int number, double x, double y,
                double side) {
  const cv::Mat bits = marker_cells(dictionary, number, border_bits);
  const int cells = bits.rows;
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
  const int cells = make_dictionary(dictionary)->markerSize + 2 * border_bits;
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
  const double left = (sheet.width_mm - side) / 2;  // This is also the distance from the top.
  for (const int number : numbers) {
    if (number < 0 || number >= markers_in(dictionary)) {
      return fail(ErrorCode::kInvalid, fmt::format("{} has no marker {}: its numbers are 0 to {}", dictionary,
                                                   number, markers_in(dictionary) - 1));
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

namespace {

constexpr double kPointsPerMm = 72 / 25.4;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '(' || c == ')' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

// PDF drawing operators, in millimetres from the bottom left corner. All rectangles are one path,
// so that viewers show no seams between adjacent ones.
std::string content_of(const Page& page, double height_mm) {
  std::string out = fmt::format("{0:.10f} 0 0 {0:.10f} 0 0 cm\n0 g\n", kPointsPerMm);
  for (const Rectangle& r : page.black) {
    out +=
        fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", r.x, height_mm - r.y - r.height, r.width, r.height);
  }
  out += "f\n";
  for (const Text& t : page.texts) {
    out += fmt::format("BT /F1 {:.3f} Tf {:.3f} {:.3f} Td ({}) Tj ET\n", t.height_mm, t.x, height_mm - t.y,
                       escaped(t.text));
  }
  return out;
}

}  // namespace

std::string to_pdf(const Sheet& sheet) {
  std::vector<std::string> objects;  // Objects are numbered from 1.
  const std::size_t first_page = 4;  // Catalog, page tree and font come first.
  std::string kids;
  for (std::size_t i = 0; i < sheet.pages.size(); ++i) kids += fmt::format("{} 0 R ", first_page + 2 * i);
  objects.push_back("<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>");
  objects.push_back(fmt::format("<< /Type /Pages /Kids [ {}] /Count {} >>", kids, sheet.pages.size()));
  objects.push_back("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>");
  for (std::size_t i = 0; i < sheet.pages.size(); ++i) {
    objects.push_back(fmt::format(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Resources << /Font << /F1 3 0 R >> >> "
        "/Contents {} 0 R >>",
        sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm, first_page + 2 * i + 1));
    const std::string content = content_of(sheet.pages[i], sheet.height_mm);
    objects.push_back(fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content));
  }
  std::string pdf = "%PDF-1.4\n", places = "0000000000 65535 f \n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    places += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const std::size_t table = pdf.size();
  return pdf + fmt::format("xref\n0 {0}\n{1}trailer\n<< /Size {0} /Root 1 0 R >>\nstartxref\n{2}\n%%EOF\n",
                           objects.size() + 1, places, table);
}

}  // namespace copresence::calibrate
