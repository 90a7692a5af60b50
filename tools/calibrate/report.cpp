#include "tools/calibrate/report.h"

#include <fmt/format.h>

#include <fstream>

namespace copresence::calibrate {

std::string to_text(const alignment::Agreement& agreement) {
  if (agreement.points == 0) return "no surface in common";
  return fmt::format(
      "{:.0f} % overlap, median {:.1f} mm ({:.1f} sigma), 95 % within {:.1f} mm ({:.1f} sigma), "
      "{:.1f} % contradicted",
      100 * agreement.overlap, 1000 * agreement.median_m, agreement.median_sigmas, 1000 * agreement.p95_m,
      agreement.p95_sigmas, 100 * agreement.contradicted);
}

nlohmann::json to_json(const alignment::Agreement& agreement) {
  return {{"overlap", agreement.overlap},
          {"contradicted", agreement.contradicted},
          {"median_mm", 1000 * agreement.median_m},
          {"p95_mm", 1000 * agreement.p95_m},
          {"median_sigmas", agreement.median_sigmas},
          {"p95_sigmas", agreement.p95_sigmas},
          {"rms_mm", 1000 * agreement.rms_m},
          {"points", agreement.points}};
}

bool says_something(const alignment::Agreement& agreement) {
  return agreement.overlap >= kLeastJudged || agreement.contradicted > 0.5;
}

std::string complaint(const alignment::Agreement& agreement, const Limits& limits) {
  if (!says_something(agreement)) return {};
  const double median_mm = 1000 * agreement.median_m, contradicted = 100 * agreement.contradicted;
  if (contradicted > limits.most_contradicted_percent) {
    return fmt::format(
        "{:.1f} % of the surfaces of one stand where the other sees through (at most {:.1f} %)", contradicted,
        limits.most_contradicted_percent);
  }
  if (median_mm > limits.most_median_mm) {
    return fmt::format("surfaces lie {:.1f} mm apart (at most {:.1f} mm)", median_mm, limits.most_median_mm);
  }
  if (agreement.median_sigmas > limits.most_median_sigmas) {
    return fmt::format("surfaces lie {:.1f} times the expected noise apart (at most {:.1f})",
                       agreement.median_sigmas, limits.most_median_sigmas);
  }
  return {};
}

Result<void> write_json(const nlohmann::json& json, const std::string& path) {
  std::ofstream file(path);
  // Names and files may hold any bytes; JSON holds UTF-8.
  file << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  file.close();
  if (!file) return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written", path));
  return {};
}

}  // namespace copresence::calibrate
