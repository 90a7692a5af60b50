#include <fmt/format.h>

#include <array>
#include <cstdio>

#include "common/command_line/parse_errors.h"
#include "common/version.h"
#include "tools/calibrate/command.h"

int main(int argc, char** argv) {
  using namespace copresence::calibrate;
  CLI::App program{
      "Finds the intrinsics and poses of cameras, and their errors in millimetres. The guide is "
      "docs/guide/calibration.md.",
      "calibrate"};
  program.set_version_flag("--version", std::string("calibrate ") + copresence::kVersion);
  program.require_subcommand(1);
  const std::array commands{intrinsics_command(program), markers_command(program), refine_command(program),
                            check_command(program), print_command(program)};
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return copresence::command_line::report_parse_error(program, error);
  }
  for (const Command& command : commands) {
    if (!command.parser->parsed()) continue;
    if (const auto done = command.run(); !done) {
      std::fflush(stdout);  // Writes all other output before the error message.
      fmt::print(stderr, "calibrate {}: {}\n", command.parser->get_name(), done.error().what);
      return 1;
    }
  }
  return 0;
}
