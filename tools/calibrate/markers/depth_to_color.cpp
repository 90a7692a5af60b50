#include "tools/calibrate/markers/depth_to_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <vector>

#include "tools/calibrate/geometry/joint_fit.h"
#include "tools/calibrate/geometry/layout.h"
#include "tools/calibrate/markers/camera_sightings.h"

namespace copresence::calibrate {
namespace {

constexpr std::size_t kDepth = 0, kColor = 1;  // the two cameras, as the fit numbers them
constexpr double kRaggedPx = 0.7;              // of an outline that is seen by where depth ends

// The colour camera knows rays only; a first guess of the depth along them is the depth camera's.
void add_color_sightings(const FoundMarker& marker, const CameraModel& color,
                         std::vector<calibration::Sighting>& all) {
  std::vector<Eigen::Vector2d> points = marker.corners;
  points.insert(points.begin(), marker.middle);
  const std::size_t of_depth = all.size() - points.size();  // the same points, added just before
  for (std::size_t part = 0; part < points.size(); ++part) {
    calibration::Sighting sighting = all[of_depth + part];
    sighting.camera = kColor;
    sighting.ray = unproject(color, points[part], 1).head<2>();
    sighting.ray_sigma = marker.sigma_px / color.fx;
    sighting.inverse_z_sigma = calibration::kUnknownDepth;
    all.push_back(sighting);
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
  // White where every frame has depth, black where none has: the markers' dark cells.
  Image<std::uint8_t> presence(measured_.width(), measured_.height());
  for (std::size_t i = 0; i < presence.pixels().size(); ++i) {
    presence.data()[i] = static_cast<std::uint8_t>(measured_.data()[i] * 255 / average_.frames());
  }
  MarkerFinder in_depth = in_depth_;
  in_depth.add_gray(presence);
  const std::vector<FoundMarker> by_color = in_color_.found(color);
  std::vector<calibration::Sighting> sightings;
  std::vector<calibration::NamedPoint> points;
  std::vector<FoundMarker> by_depth = in_depth.found(depth);
  if (by_depth.size() < calibration::kFewestMarkers && by_color.size() >= calibration::kFewestMarkers) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("colour shows {} markers, but where depth is missing only {} show, of at least {}: their "
                    "dark cells must return no depth, as aluminium foil does, and their white ones must",
                    by_color.size(), by_depth.size(), calibration::kFewestMarkers));
  }
  for (FoundMarker& marker : by_depth) {
    const auto other = std::find_if(by_color.begin(), by_color.end(),
                                    [&](const FoundMarker& m) { return m.name == marker.name; });
    if (other == by_color.end()) continue;
    marker.sigma_px = kRaggedPx;
    CameraSightings seen =
        sightings_of(kDepth, "depth", depth, std::span(&marker, 1), average_, {marker.name});
    if (seen.sightings.size() != 1 + marker.corners.size()) continue;
    for (calibration::Sighting& sighting : seen.sightings) {
      sighting.marker = points.size();
      sightings.push_back(sighting);
    }
    points.push_back({marker.name, seen.sightings[0].point_in_camera()});
    add_color_sightings(*other, color, sightings);
  }
  if (auto usable =
          calibration::check_layout(points, calibration::Form::kRigid, "the depth and the colour camera");
      !usable) {
    return fail(usable.error());
  }

  const std::vector<Rigid3> start(2);  // a sensor's two cameras stand side by side
  const calibration::JointFit joint = calibration::fit_jointly(sightings, start, kDepth);
  DepthToColor out;
  out.color_from_depth = joint.world_from_camera[kColor].inverse();
  out.markers = static_cast<int>(points.size());
  double squares = 0, shifts = 0;
  int corners = 0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (sightings[i].camera != kDepth || sightings[i].part == 0) continue;
    const Eigen::Vector3d p = out.color_from_depth * sightings[i].point_in_camera();
    const calibration::Sighting& there =
        *std::find_if(sightings.begin(), sightings.end(), [&](const calibration::Sighting& s) {
          return s.camera == kColor && s.marker == sightings[i].marker && s.part == sightings[i].part;
        });
    const Eigen::Vector2d off = p.head<2>() / p.z() - there.ray;
    const double px = std::hypot(off.x() * color.fx, off.y() * color.fy);
    squares += px * px;
    out.worst_px = std::max(out.worst_px, px);
    ++corners;
  }
  for (const calibration::NamedPoint& point : points) {
    shifts += std::pow(joint.expected_shift_m(kColor, point.position), 2);
  }
  out.rms_px = std::sqrt(squares / corners);
  out.expected_shift_m = std::sqrt(shifts / out.markers);
  return out;
}

}  // namespace copresence::calibrate
