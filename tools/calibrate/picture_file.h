#pragma once

// Pictures for people: labels that can be read on anything, and files.

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "common/result.h"

namespace copresence::calibrate {

/// `at` is the left end of the text's base line.
void write_label(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& color);

/// Fails  kInvalid where the name's end is that of no picture, kUnavailable where it cannot be written.
Result<void> write_picture(const cv::Mat& picture, const std::filesystem::path& file);

}  // namespace copresence::calibrate
