#pragma once

// Pictures for people: labels that can be read on anything, and files.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "common/result.h"

namespace copresence::calibrate {

/// For Option::check(): a file that can be written, of a kind of picture that can be.
CLI::Validator picture_file_name();

/// `at` is the left end of the text's base line.
void write_label(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& color);

/// Fails  kUnavailable where it cannot be written. Requires a name that picture_file_name() takes.
Result<void> write_picture(const cv::Mat& picture, const std::filesystem::path& file);

}  // namespace copresence::calibrate
