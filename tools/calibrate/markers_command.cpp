#include "tools/calibrate/command.h"

namespace copresence::calibrate {

Command markers_command(CLI::App& program) {
  CLI::App* parser =
      program.add_subcommand("markers", "finds where cameras stand from markers that they see");
  return {parser, [] { return Result<void>(fail(ErrorCode::kUnsupported, "is not there yet")); }};
}

}  // namespace copresence::calibrate
