#pragma once

// The commands of the program `calibrate`, and options that several commands share. Each command is
// a subcommand of the command line. The command's source file lies in the folder of its subject.

#include <CLI/CLI.hpp>
#include <functional>
#include <initializer_list>
#include <string>

#include "common/result.h"

namespace copresence::calibrate {

struct Command {
  const CLI::App* parser = nullptr;  ///< The command's parser; parsed() is true if the user gave the command.
  /// Runs the command; call it after parsing. Writes results to standard output and files, and
  /// progress to standard error.
  /// Fails with one sentence that says what to do; the program then exits with 1.
  std::function<Result<void>()> run;
};

Command intrinsics_command(CLI::App& program);
Command markers_command(CLI::App& program);
Command refine_command(CLI::App& program);
Command check_command(CLI::App& program);
Command print_command(CLI::App& program);

/// Adds the flag `--overwrite`, which allows replacing existing output files.
CLI::Option* add_overwrite(CLI::App& parser, bool& overwrite);

/// Fails with kInvalid and names the file if one of `files` exists and `overwrite` is false.
/// Ignores empty names and special files such as /dev/stdout.
Result<void> refuse_existing(std::initializer_list<std::string> files, bool overwrite);

/// Like refuse_existing(), but accepts an existing scene file, because the command updates it.
/// Fails with kInvalid if `file` exists, is not a scene file, and `overwrite` is false.
Result<void> refuse_other_than_scene(const std::string& file, bool overwrite);

/// Adds `--dictionary` (see canonical_dictionary()) and `--border-bits`.
void add_dictionary(CLI::App& parser, std::string& dictionary, int& border_bits, const std::string& help);

}  // namespace copresence::calibrate
