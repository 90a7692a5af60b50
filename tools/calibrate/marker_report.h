#pragma once

// What `calibrate markers` says: a table for people, JSON for programs.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/calibrate/geometry/world_fit.h"
#include "tools/calibrate/markers/camera_sightings.h"

namespace copresence::calibrate {

struct MarkerReport {
  calibration::Names names;
  std::size_t reference = 0;
  calibration::Form form = calibration::Form::kRigid;
  bool of_board = false;  ///< the markers are a chessboard's corners: too many to list one by one
  calibration::WorldFit fit;
  std::vector<std::vector<MarkerDepth>> depths;  ///< per camera
  std::vector<Unused> unused;
};

/// Lines of text, the last one with a newline. Millimetres and degrees.
std::string to_text(const MarkerReport& report);

/// {"solver","reference","noise_ratio","cameras":[{"name","markers","rms_mm","worst_mm","worst_marker",
/// "leave_one_out_mm","leave_one_out_worst_mm","expected_shift_mm","expected_turn_deg","world_from_camera",
/// "depths":[{"marker","z_m","pixels","share","rms_steps"}]}],"markers":[{"name","cameras","world","rms_mm","worst_mm",
/// "worst_camera"}],"pairs":[{"a","b","markers","in_tree","rigid_rms_mm","linear_rms_mm","linear_scale","no_linear"}],
/// "unused":[{"camera","marker","why"}]}; what is not known is null.
nlohmann::json to_json(const MarkerReport& report);

}  // namespace copresence::calibrate
