#pragma once

// One verb of the program `calibrate`: its options hang on a subcommand of the command line, and `run` does what they
// ask for once they have been parsed. Each verb is one source file; main.cpp lists them.

#include <CLI/CLI.hpp>
#include <functional>

#include "common/result.h"

namespace copresence::calibrate {

struct Command {
  const CLI::App* parser = nullptr;  ///< the program's own; tells whether this verb was called
  /// Results go to standard output and files, progress to standard error.
  /// Fails  with one sentence that says what to do; the program then leaves with 1.
  std::function<Result<void>()> run;
};

Command intrinsics_command(CLI::App& program);
Command markers_command(CLI::App& program);
Command refine_command(CLI::App& program);
Command check_command(CLI::App& program);
Command print_command(CLI::App& program);

}  // namespace copresence::calibrate
