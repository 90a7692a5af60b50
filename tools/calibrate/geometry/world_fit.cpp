#include "tools/calibrate/geometry/world_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "tools/calibrate/geometry/bundle_adjustment.h"
#include "tools/calibrate/geometry/rigid_fit.h"

namespace copresence::calibrate {
namespace {

// Each camera's observation of each marker's centre, by camera and marker; null if there is none.
using Seen = std::vector<std::vector<const Observation*>>;

Seen by_camera_and_marker(std::span<const Observation> observations, const RigNames& names) {
  Seen seen(names.cameras.size(), std::vector<const Observation*>(names.markers.size(), nullptr));
  for (const Observation& observation : observations) {
    assert(observation.camera < names.cameras.size() && observation.marker < names.markers.size());
    if (observation.part == 0) seen[observation.camera][observation.marker] = &observation;
  }
  return seen;
}

struct Link {
  PairFit report;
  Rigid3 a_from_b;
  std::optional<Error> problem;  ///< The reason why this pair cannot be used.
};

Link fit_pair(const Seen& seen, const RigNames& names, std::size_t a, std::size_t b,
              const WorldSettings& settings) {
  Link link;
  link.report.a = a;
  link.report.b = b;
  std::vector<NamedPoint> points;
  std::vector<PointPair> pairs;
  for (std::size_t m = 0; m < names.markers.size(); ++m) {
    const Observation *in_a = seen[a][m], *in_b = seen[b][m];
    if (!in_a || !in_b) continue;
    points.push_back({names.markers[m], in_a->point_in_camera()});
    const double sigma_a = in_a->z_sigma_m(), sigma_b = in_b->z_sigma_m();
    pairs.push_back(
        {in_b->point_in_camera(), in_a->point_in_camera(), 1 / (sigma_a * sigma_a + sigma_b * sigma_b)});
  }
  link.report.markers = pairs.size();
  const std::string cameras = names.cameras[a] + " and " + names.cameras[b];
  const bool is_board = settings.is_board && points.size() >= kFewestMarkers;
  if (const auto usable = check_layout(points, settings.solver, cameras); !usable && !is_board) {
    link.problem = usable.error();
    return link;
  }
  link.a_from_b = fit_rigid(pairs);
  link.report.rigid_rms_m = rms_distance(link.a_from_b, pairs);
  if (const auto usable = check_layout(points, Solver::kLinear, cameras); usable) {
    const LinearFit linear = fit_linear(pairs);
    link.report.linear_rms_m = rms_distance(linear.rigid, pairs);
    link.report.least_scale = linear.least_scale;
    link.report.most_scale = linear.most_scale;
    if (settings.solver == Solver::kLinear) link.a_from_b = linear.rigid;
  } else {
    link.report.no_linear = usable.error().what;
  }
  return link;
}

std::vector<Link> fit_pairs(const Seen& seen, const RigNames& names, const WorldSettings& settings) {
  std::vector<Link> links;
  for (std::size_t a = 0; a < names.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < names.cameras.size(); ++b)
      links.push_back(fit_pair(seen, names, a, b, settings));
  }
  return links;
}

// Finds initial poses. Adds one camera at a time, by the pair that shares most markers.
Result<std::vector<Rigid3>> poses_along_tree(std::vector<Link>& links, const RigNames& names,
                                             const WorldSettings& settings) {
  std::vector<std::optional<Rigid3>> poses(names.cameras.size());
  poses[settings.reference] = settings.world_from_reference;
  const auto joins = [&](const Link& link) {
    return poses[link.report.a].has_value() != poses[link.report.b].has_value();
  };
  const auto fewer = [](const Link* x, const Link* y) {
    return !x ||
           (y && (x->report.markers < y->report.markers ||
                  (x->report.markers == y->report.markers && x->report.rigid_rms_m > y->report.rigid_rms_m)));
  };
  for (std::size_t joined = 1; joined < poses.size(); ++joined) {
    Link *best = nullptr, *nearly = nullptr;
    for (Link& link : links) {
      if (!joins(link)) continue;
      Link*& candidate = link.problem ? nearly : best;
      if (fewer(candidate, &link)) candidate = &link;
    }
    if (!best) return fail(*nearly->problem);
    best->report.in_tree = true;
    if (poses[best->report.a]) {
      poses[best->report.b] = *poses[best->report.a] * best->a_from_b;
    } else {
      poses[best->report.a] = *poses[best->report.b] * best->a_from_b.inverse();
    }
  }
  std::vector<Rigid3> out;
  for (const auto& pose : poses) out.push_back(*pose);
  return out;
}

void add(Spread& spread, double distance, std::size_t at) {
  spread.rms += distance * distance;  // Holds the sum of squares until finish().
  if (spread.count == 0 || distance > spread.worst) {
    spread.worst = distance;
    spread.worst_at = at;
  }
  ++spread.count;
}

void finish(Spread& spread) {
  if (spread.count > 0) spread.rms = std::sqrt(spread.rms / static_cast<double>(spread.count));
}

// Mean position of a marker over all cameras except `without`, weighted by the depths' variances.
std::optional<Eigen::Vector3d> mean_position(const Seen& seen, std::span<const Rigid3> poses,
                                             std::size_t marker, std::optional<std::size_t> without) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0;
  for (std::size_t c = 0; c < poses.size(); ++c) {
    if (!seen[c][marker] || c == without) continue;
    const double w = 1 / (seen[c][marker]->z_sigma_m() * seen[c][marker]->z_sigma_m());
    sum += w * (poses[c] * seen[c][marker]->point_in_camera());
    weight += w;
  }
  return weight > 0 ? std::optional<Eigen::Vector3d>(sum / weight) : std::nullopt;
}

std::size_t markers_of(const Seen& seen, std::size_t camera) {
  return static_cast<std::size_t>(std::count_if(seen[camera].begin(), seen[camera].end(),
                                                [](const Observation* s) { return s != nullptr; }));
}

// Fits the poses without one marker. Returns nothing if a camera then has too few markers.
std::optional<std::vector<Rigid3>> poses_without(std::span<const Observation> observations, const Seen& seen,
                                                 const RigNames& names, std::size_t marker,
                                                 std::span<const Rigid3> start,
                                                 const WorldSettings& settings) {
  for (std::size_t c = 0; c < start.size(); ++c) {
    if (markers_of(seen, c) - (seen[c][marker] ? 1 : 0) < 3) return std::nullopt;
  }
  std::vector<Observation> others;
  std::copy_if(observations.begin(), observations.end(), std::back_inserter(others),
               [&](const Observation& s) { return s.marker != marker; });
  if (settings.solver == Solver::kRigid)
    return adjust_bundle(others, start, settings.reference).world_from_camera;
  const Seen fewer = by_camera_and_marker(others, names);
  auto links = fit_pairs(fewer, names, settings);
  auto poses = poses_along_tree(links, names, settings);
  return poses ? std::optional(std::move(*poses)) : std::nullopt;
}

void leave_one_out(std::span<const Observation> observations, const Seen& seen, const RigNames& names,
                   const WorldSettings& settings, std::span<const Rigid3> poses, WorldFit& fit) {
  for (std::size_t m = 0; m < names.markers.size(); ++m) {
    const auto without = poses_without(observations, seen, names, m, poses, settings);
    if (!without) continue;
    for (std::size_t c = 0; c < poses.size(); ++c) {
      const auto others = mean_position(seen, *without, m, c);
      if (!seen[c][m] || !others) continue;
      add(fit.cameras[c].leave_one_out, ((*without)[c] * seen[c][m]->point_in_camera() - *others).norm(), m);
    }
  }
  for (CameraFit& camera : fit.cameras) finish(camera.leave_one_out);
}

}  // namespace

Result<WorldFit> fit_world(std::span<const Observation> observations, const RigNames& names,
                           const WorldSettings& settings) {
  assert(settings.reference < names.cameras.size());
  const Seen seen = by_camera_and_marker(observations, names);
  std::vector<Link> links = fit_pairs(seen, names, settings);
  const auto tree = poses_along_tree(links, names, settings);
  if (!tree) return fail(tree.error());

  WorldFit fit;
  for (Link& link : links) {
    if (!link.problem) fit.pairs.push_back(std::move(link.report));
  }
  fit.cameras.resize(names.cameras.size());
  fit.markers.resize(names.markers.size());
  const BundleAdjustment joint = adjust_bundle(observations, *tree, settings.reference);
  const std::vector<Rigid3>& poses = settings.solver == Solver::kRigid ? joint.world_from_camera : *tree;
  fit.noise_ratio = joint.noise_ratio;

  for (std::size_t m = 0; m < names.markers.size(); ++m) {
    const auto mean = mean_position(seen, poses, m, std::nullopt);
    MarkerFit& marker = fit.markers[m];
    if (!mean) {
      marker.in_world.setConstant(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    marker.in_world = settings.solver == Solver::kRigid ? joint.marker_in_world[m] : *mean;
    for (std::size_t c = 0; c < poses.size(); ++c) {
      if (!seen[c][m]) continue;
      const double distance = (poses[c] * seen[c][m]->point_in_camera() - marker.in_world).norm();
      add(marker.residual, distance, c);
      add(fit.cameras[c].residual, distance, m);
    }
    finish(marker.residual);
  }
  for (std::size_t c = 0; c < poses.size(); ++c) {
    CameraFit& camera = fit.cameras[c];
    camera.world_from_camera = poses[c];
    finish(camera.residual);
    double squares = 0;
    for (std::size_t m = 0; m < names.markers.size(); ++m) {
      if (seen[c][m]) squares += std::pow(joint.expected_shift_m(c, fit.markers[m].in_world), 2);
    }
    camera.expected_shift_m = std::sqrt(squares / static_cast<double>(markers_of(seen, c)));
    camera.expected_turn = joint.expected_turn(c);
  }
  leave_one_out(observations, seen, names, settings, poses, fit);
  return fit;
}

}  // namespace copresence::calibrate
