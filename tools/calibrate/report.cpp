#include "tools/calibrate/report.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string_view>

namespace copresence::calibrate {
namespace {

using nlohmann::json;
using Outcome = CameraRefinement::Outcome;

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

json rounded(double value, double unit) {
  return std::isfinite(value) ? json(std::round(value / unit) * unit) : json(nullptr);
}
json mm(double metres) {
  return rounded(metres * 1000, 0.001);
}

json matrix(const Rigid3& pose) {
  const Eigen::Matrix4d m = pose.matrix();
  json rows = json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

json camera_json(const MarkerReport& report, std::size_t c) {
  const CameraFit& camera = report.fit.cameras[c];
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
          {"world_from_camera", matrix(camera.world_from_camera)},
          {"depths", depths}};
}

std::string_view name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::kReference:
      return "reference";
    case Outcome::kRefined:
      return "refined";
    case Outcome::kKept:
    case Outcome::kPriorBetter:
    case Outcome::kNotConfirmed:
      return "kept";
    case Outcome::kNoOverlap:
      return "no_overlap";
  }
  return "";
}

std::string describe(const Direction& direction) {
  const auto list = [](const Eigen::Vector3d& v) {
    return fmt::format("{:.2f} {:.2f} {:.2f}", v.x(), v.y(), v.z());
  };
  const bool shifts = direction.shift.norm() > 0.3, turns = direction.turn.norm() > 0.3;
  if (shifts && turns) {
    return fmt::format("a shift along ({}) with a turn about ({})", list(direction.shift),
                       list(direction.turn));
  }
  return turns ? fmt::format("a turn about ({})", list(direction.turn))
               : fmt::format("a shift along ({})", list(direction.shift));
}

}  // namespace

Result<void> write_json(const json& value, const std::string& path) {
  std::ofstream file(path);
  // Names may contain any bytes, but JSON must be UTF-8.
  file << value.dump(2, ' ', false, json::error_handler_t::replace) << '\n';
  file.close();
  if (!file) return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be written", path));
  return {};
}

json to_json(const IntrinsicsFit& fit, const std::string& camera) {
  json views = json::array(), dropped = json::array();
  for (const ViewFit& view : fit.views) views.push_back({{"picture", view.picture}, {"rms_px", view.rms_px}});
  for (const DroppedView& view : fit.dropped)
    dropped.push_back({{"picture", view.picture}, {"why", view.why}});
  const CameraModel& m = fit.model;
  return {{"camera", camera},
          {"distortion_fitted", fit.distortion},
          {"rms_px", fit.rms_px},
          {"focal_sigma_px", fit.focal_sigma_px},
          {"center_sigma_px", fit.center_sigma_px},
          {"covered", fit.covered},
          {"views", views},
          {"dropped", dropped},
          {"model",
           {{"width", m.width},
            {"height", m.height},
            {"fx", m.fx},
            {"fy", m.fy},
            {"cx", m.cx},
            {"cy", m.cy},
            {"distortion", m.distortion}}}};
}

std::string to_text(const MarkerReport& report) {
  const RigNames& names = report.names;
  std::string text =
      fmt::format("camera            {}    rms  worst ({})    left out  expected shift, turn\n",
                  report.of_board ? "corners" : "markers", report.of_board ? "corner" : "marker");
  for (std::size_t c = 0; c < names.cameras.size(); ++c) {
    const CameraFit& camera = report.fit.cameras[c];
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
  for (const PairFit& pair : report.fit.pairs) {
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
  const RigNames& names = report.names;
  json cameras = json::array(), markers = json::array(), pairs = json::array(), unused = json::array();
  for (std::size_t c = 0; c < names.cameras.size(); ++c) cameras.push_back(camera_json(report, c));
  for (std::size_t m = 0; m < names.markers.size(); ++m) {
    const MarkerFit& marker = report.fit.markers[m];
    if (marker.residual.count == 0) continue;
    markers.push_back({{"name", names.markers[m]},
                       {"cameras", marker.residual.count},
                       {"world", {marker.in_world.x(), marker.in_world.y(), marker.in_world.z()}},
                       {"rms_mm", mm(marker.residual.rms)},
                       {"worst_mm", mm(marker.residual.worst)},
                       {"worst_camera", names.cameras[marker.residual.worst_at]}});
  }
  for (const PairFit& pair : report.fit.pairs) {
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
  return {{"solver", report.solver == Solver::kRigid ? "rigid" : "linear"},
          {"reference", names.cameras[report.reference]},
          {"noise_ratio", rounded(report.fit.noise_ratio, 0.001)},
          {"cameras", cameras},
          {"markers", markers},
          {"pairs", pairs},
          {"unused", unused}};
}

std::string to_text(const Agreement& agreement) {
  if (agreement.points == 0) return "no surface in common";
  return fmt::format(
      "{:.0f} % overlap, median {:.1f} mm ({:.1f} sigma), 95 % within {:.1f} mm ({:.1f} sigma), "
      "{:.1f} % contradicted",
      100 * agreement.overlap, 1000 * agreement.median_m, agreement.median_sigmas, 1000 * agreement.p95_m,
      agreement.p95_sigmas, 100 * agreement.contradicted);
}

json to_json(const Agreement& agreement) {
  return {{"overlap", agreement.overlap},
          {"contradicted", agreement.contradicted},
          {"median_mm", 1000 * agreement.median_m},
          {"p95_mm", 1000 * agreement.p95_m},
          {"median_sigmas", agreement.median_sigmas},
          {"p95_sigmas", agreement.p95_sigmas},
          {"rms_mm", 1000 * agreement.rms_m},
          {"points", agreement.points}};
}

bool is_judged(const Agreement& agreement) {
  return agreement.overlap >= kLeastJudged || agreement.contradicted > 0.5;
}

std::string problem_of(const Agreement& agreement, const Limits& limits) {
  if (!is_judged(agreement)) return {};
  const double median_mm = 1000 * agreement.median_m, contradicted = 100 * agreement.contradicted;
  if (contradicted > limits.most_contradicted_percent) {
    return fmt::format("one camera sees through {:.1f} % of the other's surfaces (at most {:.1f} %)",
                       contradicted, limits.most_contradicted_percent);
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

std::string to_text(const CameraRefinement& camera) {
  switch (camera.outcome) {
    case Outcome::kReference:
      return "the reference, not moved";
    case Outcome::kKept:
      return "kept as given: no pose nearby makes the surfaces agree better";
    case Outcome::kPriorBetter:
      return fmt::format("kept as given: its error is {:.1f} mm, and that of the surfaces alone is {:.1f} mm",
                         camera.prior_mm, camera.surfaces_mm);
    case Outcome::kNotConfirmed:
      return fmt::format(
          "kept as given (error {:.1f} mm): surfaces that were left out of the fit do not agree better at "
          "the "
          "new pose",
          camera.prior_mm);
    case Outcome::kNoOverlap:
      return fmt::format(
          "kept as given: it shares less than {:.0f} % of its surfaces with the others; turn the cameras so "
          "that "
          "they see more of the same surfaces, or add markers",
          100 * kLeastOverlap);
    case Outcome::kRefined:
      break;
  }
  std::string text = fmt::format("moved {:.1f} mm and {:.2f} degrees", camera.moved_mm, camera.moved_deg);
  text += camera.error_mm > 0 ? fmt::format(", expected error {:.1f} mm", camera.error_mm)
                              : ", its error is unknown";
  if (camera.contradicts_prior) {
    text += fmt::format(
        "; the surfaces disagree with the given pose by more than its error of {:.1f} mm explains, so that "
        "error was enlarged: was the camera touched since `calibrate markers`?",
        camera.prior_mm);
  }
  for (const Direction& direction : camera.unobservable) {
    text += fmt::format(
        "; the surfaces do not determine {}, so that part is as given: put an object with corners "
        "where both cameras see it",
        describe(direction));
  }
  return text;
}

json to_json(const Refinement& refinement, std::span<const StillView> views) {
  json cameras = json::array(), pairs = json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CameraRefinement& camera = refinement.cameras[i];
    json unobservable = json::array();
    for (const Direction& direction : camera.unobservable) {
      unobservable.push_back({{"turn", {direction.turn.x(), direction.turn.y(), direction.turn.z()}},
                              {"shift", {direction.shift.x(), direction.shift.y(), direction.shift.z()}},
                              {"resistance", direction.observability}});
    }
    cameras.push_back({{"name", views[i].name},
                       {"unsteady", views[i].unsteady},
                       {"outcome", name_of(camera.outcome)},
                       {"says", to_text(camera)},
                       {"moved_mm", camera.moved_mm},
                       {"moved_deg", camera.moved_deg},
                       {"told_mm", camera.prior_mm},
                       {"surfaces_mm", camera.surfaces_mm},
                       {"error_mm", camera.error_mm},
                       {"contradicts_told", camera.contradicts_prior},
                       {"unsupported", unobservable},
                       {"world_from_camera", matrix(camera.world_from_camera)}});
  }
  for (const PairRefinement& pair : refinement.pairs) {
    pairs.push_back({{"a", views[pair.a].name},
                     {"b", views[pair.b].name},
                     {"before", to_json(pair.before)},
                     {"after", to_json(pair.after)}});
  }
  return {{"cameras", cameras}, {"pairs", pairs}, {"least_resistance", refinement.least_observability}};
}

}  // namespace copresence::calibrate
