#pragma once

// Reports of all commands: text for people, JSON for programs. Thread: pure functions.

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/calibrate/geometry/world_fit.h"
#include "tools/calibrate/intrinsics/intrinsics_fit.h"
#include "tools/calibrate/markers/marker_observations.h"
#include "tools/calibrate/refinement/refinement.h"
#include "tools/calibrate/refinement/still_view.h"

namespace copresence::calibrate {

/// Fails with kUnavailable if the file cannot be written.
Result<void> write_json(const nlohmann::json& json, const std::string& path);

/// {"camera","distortion_fitted","rms_px","focal_sigma_px","center_sigma_px","covered","views":[{"picture","rms_px"}],
/// "dropped":[{"picture","why"}],"model":{"width","height","fx","fy","cx","cy","distortion"}}
nlohmann::json to_json(const IntrinsicsFit& fit, const std::string& camera);

/// The result of `calibrate markers`.
struct MarkerReport {
  RigNames names;
  std::size_t reference = 0;
  Solver solver = Solver::kRigid;
  bool of_board = false;  ///< True for corners of a chessboard, which the text does not list.
  WorldFit fit;
  std::vector<std::vector<MarkerDepth>> depths;
  std::vector<Unused> unused;
};

/// Lines of text that end with a newline. Lengths are in millimetres, angles in degrees.
std::string to_text(const MarkerReport& report);

/// {"solver","reference","noise_ratio","cameras":[{"name","markers","rms_mm","worst_mm","worst_marker",
/// "leave_one_out_mm","leave_one_out_worst_mm","expected_shift_mm","expected_turn_deg","world_from_camera",
/// "depths":[{"marker","z_m","pixels","share","rms_steps"}]}],"markers":[{"name","cameras","world","rms_mm","worst_mm",
/// "worst_camera"}],"pairs":[{"a","b","markers","in_tree","rigid_rms_mm","linear_rms_mm","linear_scale","no_linear"}],
/// "unused":[{"camera","marker","why"}]}; unknown values are null.
nlohmann::json to_json(const MarkerReport& report);

/// Such as `37 % overlap, median 6.6 mm (0.9 sigma), 95 % within 30.8 mm (2.1 sigma), 0.4 %
/// contradicted`.
std::string to_text(const Agreement& agreement);

/// {"overlap","contradicted","median_mm","p95_mm","median_sigmas","p95_sigmas","rms_mm","points"}
nlohmann::json to_json(const Agreement& agreement);

/// Limits of a good pair of cameras.
struct Limits {
  double most_median_sigmas = 2, most_median_mm = 15, most_contradicted_percent = 5;
};

/// A pair with less overlap is not judged.
inline constexpr double kLeastJudged = 0.05;
bool is_judged(const Agreement& agreement);

/// Describes the limit that a pair exceeds. Empty if it exceeds none or is not judged.
std::string problem_of(const Agreement& agreement, const Limits& limits);

/// Describes what happened to a camera.
std::string to_text(const CameraRefinement& camera);

/// {"cameras":[{"name","unsteady","outcome","says","moved_mm","moved_deg","told_mm","surfaces_mm","error_mm",
/// "contradicts_told","unsupported":[{"turn","shift","resistance"}],"world_from_camera"}],"pairs":[{"a","b","before",
/// "after"}],"least_resistance"}
nlohmann::json to_json(const Refinement& refinement, std::span<const StillView> views);

}  // namespace copresence::calibrate
