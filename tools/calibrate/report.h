#pragma once

// How agreements between cameras are told to people and to programs.

#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"
#include "tools/calibrate/alignment/agreement.h"

namespace copresence::calibrate {

/// `37 % overlap, median 6.6 mm (0.9 sigma), 95 % within 30.8 mm (2.1 sigma), 0.4 % contradicted`
std::string to_text(const alignment::Agreement& agreement);

/// {"overlap","contradicted","median_mm","p95_mm","median_sigmas","p95_sigmas","rms_mm","points"}
nlohmann::json to_json(const alignment::Agreement& agreement);

/// Up to where a pair of cameras is called good.
struct Limits {
  double most_median_sigmas = 2, most_median_mm = 15, most_contradicted_percent = 5;
};

/// A pair that shares less of its surfaces says nothing either way.
inline constexpr double kLeastJudged = 0.05;
bool says_something(const alignment::Agreement& agreement);

/// What is wrong with a pair, in words; empty where nothing is, or where it says nothing.
std::string complaint(const alignment::Agreement& agreement, const Limits& limits);

/// Fails  kUnavailable where the file cannot be written.
Result<void> write_json(const nlohmann::json& json, const std::string& path);

}  // namespace copresence::calibrate
