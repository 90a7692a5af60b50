#pragma once

// Reports invalid command lines, and prints --help and --version. Thread: the main thread.

#include <CLI/CLI.hpp>
#include <string>

namespace copresence::command_line {

/// Prints help or the version to standard output, and a parse error as one sentence to standard
/// error. Returns the program's exit code, 0 or 2. Requires an `error` from app.parse().
int report_parse_error(const CLI::App& app, const CLI::ParseError& error);

/// Returns the message of a parse error without the program's name and without a full stop.
std::string parse_error_message(const CLI::ParseError& error);

}  // namespace copresence::command_line
