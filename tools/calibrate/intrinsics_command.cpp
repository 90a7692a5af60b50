#include "tools/calibrate/command.h"

namespace copresence::calibrate {

Command intrinsics_command(CLI::App& program) {
  CLI::App* parser =
      program.add_subcommand("intrinsics", "finds a camera's lens from pictures of a chessboard");
  return {parser, [] { return Result<void>(fail(ErrorCode::kUnsupported, "is not there yet")); }};
}

}  // namespace copresence::calibrate
