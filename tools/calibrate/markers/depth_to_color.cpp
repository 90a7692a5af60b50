#include "tools/calibrate/markers/depth_to_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <vector>

#include "tools/calibrate/geometry/bundle_adjustment.h"
#include "tools/calibrate/geometry/marker_layout.h"
#include "tools/calibrate/markers/marker_observations.h"

namespace copresence::calibrate {
namespace {

constexpr std::size_t kDepth = 0, kColor = 1;
constexpr double kRaggedPx = 0.7;  // Error of an outline found from missing depth, pixels.

// The colour camera measures only rays. Depth from the depth camera is the first guess.
void add_color_observations(const FoundMarker& marker, const CameraModel& color,
                            std::vector<Observation>& all) {
  std::vector<Eigen::Vector2d> points = marker.corners;
  points.insert(points.begin(), marker.middle);
  const std::size_t of_depth = all.size() - points.size();  // Index of the depth camera's observations.
  for (std::size_t part = 0; part < points.size(); ++part) {
    Observation observation = all[of_depth + part];
    observation.camera = kColor;
    observation.ray = unproject(color, points[part], 1).head<2>();
    observation.ray_sigma = marker.sigma_px / color.fx;
    observation.inverse_z_sigma = kUnknownDepth;
    all.push_back(observation);
  }
}

}  // namespace

Result<DepthToColorFinder> DepthToColorFinder::open(DepthUnit unit, const std::string& dictionary,
                                                    int border_bits) {
  auto finder = MarkerFinder::open(dictionary, border_bits);
  if (!finder) return fail(finder.error());
  return DepthToColorFinder(unit, std::move(*finder));
}

void DepthToColorFinder::add_depth(const DepthImage& depth) {
  if (average_.frames() == 0) measured_ = Image<std::uint16_t>(depth.width(), depth.height());
  assert(same_shape(measured_, depth));
  average_.add(depth);
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    measured_.data()[i] = static_cast<std::uint16_t>(measured_.data()[i] + (depth.data()[i] != 0 ? 1 : 0));
  }
}

Result<DepthToColor> DepthToColorFinder::fit(const CameraModel& depth, const CameraModel& color) const {
  assert(average_.frames() > 0);
  // A picture that is white where all frames have depth, and black where no frame has. The markers'
  // dark cells are black.
  Image<std::uint8_t> presence(measured_.width(), measured_.height());
  for (std::size_t i = 0; i < presence.pixels().size(); ++i) {
    presence.data()[i] = static_cast<std::uint8_t>(measured_.data()[i] * 255 / average_.frames());
  }
  MarkerFinder in_depth = in_depth_;
  in_depth.add_gray(presence);
  const std::vector<FoundMarker> by_color = in_color_.found(color);
  std::vector<Observation> observations;
  std::vector<NamedPoint> points;
  std::vector<FoundMarker> by_depth = in_depth.found(depth);
  if (by_depth.size() < kFewestMarkers && by_color.size() >= kFewestMarkers) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("colour shows {} markers, but where depth is missing only {} show, of at least {}: their "
                    "dark cells must return no depth, as aluminium foil does, and their white ones must",
                    by_color.size(), by_depth.size(), kFewestMarkers));
  }
  for (FoundMarker& marker : by_depth) {
    const auto other = std::find_if(by_color.begin(), by_color.end(),
                                    [&](const FoundMarker& m) { return m.name == marker.name; });
    if (other == by_color.end()) continue;
    marker.sigma_px = kRaggedPx;
    CameraObservations seen =
        observations_of(kDepth, "depth", depth, std::span(&marker, 1), average_, {marker.name});
    if (seen.observations.size() != 1 + marker.corners.size()) continue;
    for (Observation& observation : seen.observations) {
      observation.marker = points.size();
      observations.push_back(observation);
    }
    points.push_back({marker.name, seen.observations[0].point_in_camera()});
    add_color_observations(*other, color, observations);
  }
  if (auto usable = check_layout(points, Solver::kRigid, "the depth and the colour camera"); !usable) {
    return fail(usable.error());
  }

  const std::vector<Rigid3> start(2);  // A sensor's two cameras are close together.
  const BundleAdjustment joint = adjust_bundle(observations, start, kDepth);
  DepthToColor out;
  out.color_from_depth = joint.world_from_camera[kColor].inverse();
  out.markers = static_cast<int>(points.size());
  double squares = 0, shifts = 0;
  int corners = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (observations[i].camera != kDepth || observations[i].part == 0) continue;
    const Eigen::Vector3d p = out.color_from_depth * observations[i].point_in_camera();
    const Observation& there =
        *std::find_if(observations.begin(), observations.end(), [&](const Observation& s) {
          return s.camera == kColor && s.marker == observations[i].marker && s.part == observations[i].part;
        });
    const Eigen::Vector2d off = p.head<2>() / p.z() - there.ray;
    const double px = std::hypot(off.x() * color.fx, off.y() * color.fy);
    squares += px * px;
    out.worst_px = std::max(out.worst_px, px);
    ++corners;
  }
  for (const NamedPoint& point : points) {
    shifts += std::pow(joint.expected_shift_m(kColor, point.position), 2);
  }
  out.rms_px = std::sqrt(squares / corners);
  out.expected_shift_m = std::sqrt(shifts / out.markers);
  return out;
}

}  // namespace copresence::calibrate
