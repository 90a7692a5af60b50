#pragma once

// What a program says of a command line that it cannot take, and of --help and --version.
//
// Thread: none but the main one.

#include <CLI/CLI.hpp>

namespace copresence::command_line {

/// Prints what `error` is about: help or version to standard output, a mistake as one sentence to standard error. Returns the
/// program's exit code, 0 or 2. Requires that `error` came out of app.parse() or what follows it.
int explain(const CLI::App& app, const CLI::ParseError& error);

/// The mistake alone, as a sentence's beginning without the program's name.
std::string sentence_of(const CLI::ParseError& error);

}  // namespace copresence::command_line
