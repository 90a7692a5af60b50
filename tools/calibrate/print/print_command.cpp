#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <memory>

#include "common/command_line/values.h"
#include "tools/calibrate/command.h"
#include "tools/calibrate/print/sheet.h"

namespace copresence::calibrate {
namespace {

enum class What { kChessboard, kCharuco, kMarkers };
enum class Size { kA4, kA3 };

struct PrintSettings {
  What what = What::kChessboard;
  Size paper = Size::kA4;
  std::string size, ids = "0-5", out;
  Board board;
  double square_mm = 0, marker_mm = 0;
  bool overwrite = false;
};

constexpr int kMostPages = 200;

// Parses "0-5" or "3,7,9-11". Returns an error message, or nothing.
std::string parse_ids(const std::string& text, std::vector<int>& numbers) {
  const std::string wrong =
      fmt::format("\"{}\" is not a list of markers' numbers, such as 0-5 or 3,7,9-11", text);
  const auto parse = [](std::string_view part, int& number) {
    const auto parsed = std::from_chars(part.data(), part.data() + part.size(), number);
    return parsed.ec == std::errc() && parsed.ptr == part.data() + part.size() && number >= 0;
  };
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    const std::size_t dash = part.find('-');
    int first = 0, last = 0;
    if (!parse(part.substr(0, dash), first)) return wrong;
    last = first;
    if (dash != std::string_view::npos && !parse(part.substr(dash + 1), last)) return wrong;
    if (last < first || last - first >= kMostPages) return wrong;
    for (int number = first; number <= last; ++number) numbers.push_back(number);
    if (numbers.size() > kMostPages)
      return fmt::format("{} pages are too many, at most {}", numbers.size(), kMostPages);
    if (comma == std::string_view::npos) return {};
    rest.remove_prefix(comma + 1);
  }
}

Result<Sheet> sheet_of(PrintSettings& settings) {
  const Paper& paper = settings.paper == Size::kA4 ? kA4 : kA3;
  Board& board = settings.board;
  if (settings.what == What::kMarkers) {
    std::vector<int> numbers;
    if (const std::string wrong = parse_ids(settings.ids, numbers); !wrong.empty()) {
      return fail(ErrorCode::kInvalid, wrong);
    }
    return marker_sheet(board.dictionary, board.border_bits, numbers, 1e-3 * settings.marker_mm, paper);
  }
  const bool is_chessboard = settings.what == What::kChessboard;
  board.kind = is_chessboard ? Board::Kind::kChessboard : Board::Kind::kCharuco;
  if (settings.size.empty())
    std::tie(board.columns, board.rows) = is_chessboard ? std::pair(9, 6) : std::pair(8, 6);
  board.square_m = 1e-3 * settings.square_mm;
  board.marker_m = 1e-3 * settings.marker_mm;
  return board_sheet(board, paper);
}

Result<void> run(PrintSettings& settings) {
  if (auto kept = refuse_existing({settings.out}, settings.overwrite); !kept) return kept;
  const auto sheet = sheet_of(settings);
  if (!sheet) return fail(sheet.error());
  std::ofstream file(settings.out, std::ios::binary);
  file << to_pdf(*sheet) << std::flush;
  if (!file) return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written", settings.out));
  fmt::print("{}: {}; {} {} {}\n", settings.out, sheet->content, sheet->pages.size(),
             settings.paper == Size::kA4 ? kA4.name : kA3.name, sheet->pages.size() == 1 ? "page" : "pages");
  fmt::print(
      "Print it at 100 %, without scaling, and measure the rulers. Glue it to something flat and stiff.\n");
  fmt::print("Then: {}\n", sheet->flags);
  return {};
}

}  // namespace

Command print_command(CLI::App& program) {
  auto settings = std::make_shared<PrintSettings>();
  CLI::App* parser = program.add_subcommand(
      "print", "Makes a board or markers as a PDF file to print, with rulers to check the print.");
  parser->add_option("what", settings->what, "chessboard, charuco or markers")
      ->required()
      ->transform(command_line::one_of<What>(
          {{"chessboard", What::kChessboard}, {"charuco", What::kCharuco}, {"markers", What::kMarkers}}));
  parser->add_option("--out", settings->out, "the PDF file to write")
      ->required()
      ->check(command_line::writable_file());
  parser->add_option("--paper", settings->paper, "a4 or a3 [a4]")
      ->transform(command_line::one_of<Size>({{"a4", Size::kA4}, {"a3", Size::kA3}}));
  parser
      ->add_option("--board-size", settings->size,
                   "COLUMNSxROWS: inner corners of a chessboard [9x6], squares of a ChArUco board [8x6]")
      ->check([settings](const std::string& text) { return parse_board_size(text, settings->board); });
  parser->add_option("--square", settings->square_mm, "side of a square, mm [the largest that fits]")
      ->check(command_line::number(1, 1000));
  parser
      ->add_option("--marker", settings->marker_mm,
                   "side of a marker, mm [the largest that fits; on a ChArUco board 3/4 of a square]")
      ->check(command_line::number(1, 1000));
  add_dictionary(*parser, settings->board.dictionary, settings->board.border_bits,
                 "dictionary of the ArUco or AprilTag markers");
  parser->add_option("--ids", settings->ids, "numbers of the markers, one per page: 0-5 or 3,7,9-11")
      ->capture_default_str();
  add_overwrite(*parser, settings->overwrite);
  return {parser, [settings] { return run(*settings); }};
}

}  // namespace copresence::calibrate
