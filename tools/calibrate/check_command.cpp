#include "tools/calibrate/command.h"

namespace copresence::calibrate {

Command check_command(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("check", "says how well the cameras' surfaces agree");
  return {parser, [] { return Result<void>(fail(ErrorCode::kUnsupported, "is not there yet")); }};
}

}  // namespace copresence::calibrate
