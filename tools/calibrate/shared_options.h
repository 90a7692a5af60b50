#pragma once

// Options that several verbs have, so that they are called and behave the same.

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>

#include "common/result.h"

namespace copresence::calibrate {

/// `--overwrite`: files to be written that exist already are replaced.
CLI::Option* add_overwrite(CLI::App& parser, bool& overwrite);

/// Fails  kInvalid, naming the file, where one of `files` exists already and `overwrite` is false. Empty names are left out,
///        as is what is no regular file (/dev/stdout).
Result<void> keep_existing(std::initializer_list<std::string> files, bool overwrite);

/// The same for a scene file: one that exists is updated, but another file of that name is kept.
/// Fails  kInvalid where `file` exists already, is no scene file, and `overwrite` is false.
Result<void> keep_other_than_scene(const std::string& file, bool overwrite);

/// `--dictionary`, in our spelling, OpenCV's or AprilTag's, and `--border-bits`.
void add_dictionary(CLI::App& parser, std::string& dictionary, int& border_bits, const std::string& help);

}  // namespace copresence::calibrate
