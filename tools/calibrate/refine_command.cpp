#include "tools/calibrate/command.h"

namespace copresence::calibrate {

Command refine_command(CLI::App& program) {
  CLI::App* parser =
      program.add_subcommand("refine", "refines poses on the surfaces that cameras see in common");
  return {parser, [] { return Result<void>(fail(ErrorCode::kUnsupported, "is not there yet")); }};
}

}  // namespace copresence::calibrate
