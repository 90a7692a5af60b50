#include "tools/calibrate/marker_report.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace copresence::calibrate {
namespace {

using calibration::Form;
using calibration::Spread;
using nlohmann::json;

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

json rounded(double value, double unit) {
  return std::isfinite(value) ? json(std::round(value / unit) * unit) : json(nullptr);
}
json mm(double metres) {
  return rounded(metres * 1000, 0.001);
}

json pose(const Rigid3& transform) {
  const Eigen::Matrix4d m = transform.matrix();
  json rows = json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

json camera_json(const MarkerReport& report, std::size_t c) {
  const calibration::CameraFit& camera = report.fit.cameras[c];
  const Spread &residual = camera.residual, &left_out = camera.leave_one_out;
  json depths = json::array();
  for (const MarkerDepth& depth : report.depths[c]) {
    depths.push_back({{"marker", depth.marker},
                      {"z_m", rounded(depth.z_m, 1e-4)},
                      {"pixels", depth.plane.pixels},
                      {"share", rounded(depth.plane.share, 0.001)},
                      {"rms_steps", rounded(depth.plane.rms_steps, 0.001)}});
  }
  return {{"name", report.names.cameras[c]},
          {"markers", residual.count},
          {"rms_mm", mm(residual.rms)},
          {"worst_mm", mm(residual.worst)},
          {"worst_marker", report.names.markers[residual.worst_at]},
          {"leave_one_out_mm", left_out.count ? mm(left_out.rms) : json(nullptr)},
          {"leave_one_out_worst_mm", left_out.count ? mm(left_out.worst) : json(nullptr)},
          {"expected_shift_mm", mm(camera.expected_shift_m)},
          {"expected_turn_deg", rounded(degrees(camera.expected_turn), 1e-4)},
          {"world_from_camera", pose(camera.world_from_camera)},
          {"depths", depths}};
}

}  // namespace

std::string to_text(const MarkerReport& report) {
  const calibration::Names& names = report.names;
  std::string text =
      fmt::format("camera            {}    rms  worst ({})    left out  expected shift, turn\n",
                  report.of_board ? "corners" : "markers", report.of_board ? "corner" : "marker");
  for (std::size_t c = 0; c < names.cameras.size(); ++c) {
    const calibration::CameraFit& camera = report.fit.cameras[c];
    const std::string left_out =
        camera.leave_one_out.count ? fmt::format("{:.1f} mm", 1000 * camera.leave_one_out.rms) : "-";
    const std::string expected = c == report.reference
                                     ? "reference"
                                     : fmt::format("{:.1f} mm, {:.2f} deg", 1000 * camera.expected_shift_m,
                                                   degrees(camera.expected_turn));
    text += fmt::format("{:<18}{:>6}{:>7.1f}{:>7.1f} mm ({:<4}){:>12}  {}\n", names.cameras[c],
                        camera.residual.count, 1000 * camera.residual.rms, 1000 * camera.residual.worst,
                        names.markers[camera.residual.worst_at], left_out, expected);
  }
  if (!report.of_board) text += "\nmarker            cameras    rms  worst (camera)\n";
  for (std::size_t m = 0; m < names.markers.size() && !report.of_board; ++m) {
    const Spread& residual = report.fit.markers[m].residual;
    if (residual.count < 2) continue;
    text += fmt::format("{:<18}{:>6}{:>7.1f}{:>7.1f} mm ({})\n", names.markers[m], residual.count,
                        1000 * residual.rms, 1000 * residual.worst, names.cameras[residual.worst_at]);
  }
  text += fmt::format("\npair              {}  rigid  linear (lengths)\n",
                      report.of_board ? "corners" : "markers");
  for (const calibration::PairFit& pair : report.fit.pairs) {
    const std::string linear = pair.linear_rms_m
                                   ? fmt::format("{:.1f} mm ({:.3f} to {:.3f})", 1000 * *pair.linear_rms_m,
                                                 pair.least_scale, pair.most_scale)
                                   : "the markers lie too flat for it";
    text += fmt::format("{:<18}{:>6}{:>7.1f}  {}\n", names.cameras[pair.a] + " " + names.cameras[pair.b],
                        pair.markers, 1000 * pair.rigid_rms_m, linear);
  }
  for (const Unused& unused : report.unused) {
    text += fmt::format("not used: marker {} in {}: {}\n", unused.marker, unused.camera, unused.why);
  }
  return text;
}

json to_json(const MarkerReport& report) {
  const calibration::Names& names = report.names;
  json cameras = json::array(), markers = json::array(), pairs = json::array(), unused = json::array();
  for (std::size_t c = 0; c < names.cameras.size(); ++c) cameras.push_back(camera_json(report, c));
  for (std::size_t m = 0; m < names.markers.size(); ++m) {
    const calibration::MarkerFit& marker = report.fit.markers[m];
    if (marker.residual.count == 0) continue;
    markers.push_back({{"name", names.markers[m]},
                       {"cameras", marker.residual.count},
                       {"world", {marker.in_world.x(), marker.in_world.y(), marker.in_world.z()}},
                       {"rms_mm", mm(marker.residual.rms)},
                       {"worst_mm", mm(marker.residual.worst)},
                       {"worst_camera", names.cameras[marker.residual.worst_at]}});
  }
  for (const calibration::PairFit& pair : report.fit.pairs) {
    pairs.push_back({{"a", names.cameras[pair.a]},
                     {"b", names.cameras[pair.b]},
                     {"markers", pair.markers},
                     {"in_tree", pair.in_tree},
                     {"rigid_rms_mm", mm(pair.rigid_rms_m)},
                     {"linear_rms_mm", pair.linear_rms_m ? mm(*pair.linear_rms_m) : json(nullptr)},
                     {"linear_scale", {rounded(pair.least_scale, 1e-5), rounded(pair.most_scale, 1e-5)}},
                     {"no_linear", pair.linear_rms_m ? json(nullptr) : json(pair.no_linear)}});
  }
  for (const Unused& one : report.unused) {
    unused.push_back({{"camera", one.camera}, {"marker", one.marker}, {"why", one.why}});
  }
  return {{"solver", report.form == Form::kRigid ? "rigid" : "linear"},
          {"reference", names.cameras[report.reference]},
          {"noise_ratio", rounded(report.fit.noise_ratio, 0.001)},
          {"cameras", cameras},
          {"markers", markers},
          {"pairs", pairs},
          {"unused", unused}};
}

}  // namespace copresence::calibrate
