#include "tools/calibrate/intrinsics/intrinsics_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <set>

#include "tools/calibrate/geometry/quantile.h"
#include "tools/calibrate/intrinsics/camera_split.h"

namespace copresence::calibrate {
namespace {

constexpr int kFieldsX = 8, kFieldsY = 6;

std::vector<cv::Point3f> on_board(const BoardView& view) {
  std::vector<cv::Point3f> points;
  for (const Eigen::Vector2d& p : view.on_board) points.emplace_back(float(p.x()), float(p.y()), 0.0f);
  return points;
}

std::vector<cv::Point2f> pixels(const BoardView& view) {
  std::vector<cv::Point2f> points;
  for (const Eigen::Vector2d& p : view.pixels) points.emplace_back(float(p.x()), float(p.y()));
  return points;
}

double covered_share(std::span<const BoardView> views, int width, int height) {
  std::set<std::pair<int, int>> fields;
  for (const BoardView& view : views) {
    for (const Eigen::Vector2d& p : view.pixels) {
      fields.insert({std::clamp(int(p.x() * kFieldsX / width), 0, kFieldsX - 1),
                     std::clamp(int(p.y() * kFieldsY / height), 0, kFieldsY - 1)});
    }
  }
  return static_cast<double>(fields.size()) / (kFieldsX * kFieldsY);
}

Rigid3 pose_of(const cv::Mat& turn, const cv::Mat& move) {
  cv::Mat rotation;
  cv::Rodrigues(turn, rotation);
  Rigid3 pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.rotation(r, c) = rotation.at<double>(r, c);
    pose.translation(r) = move.at<double>(r);
  }
  return pose;
}

// Sets of distortion coefficients to try, the smallest first. Too many coefficients are correlated
// and extrapolate badly beyond the corners.
struct Distortion {
  const char* used;
  int flags, coefficients;
};
constexpr std::array<Distortion, 4> kDistortions{
    {{"none", cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3, 0},
     {"k1 k2 p1 p2", cv::CALIB_FIX_K3, 4},
     {"k1 k2 k3 p1 p2", 0, 5},
     {"k1 to k6 p1 p2", cv::CALIB_RATIONAL_MODEL, 8}}};

// `start` has initial intrinsics. If it is null, they are estimated from the views.
Result<IntrinsicsFit> fit_once(std::span<const BoardView> views, int width, int height,
                               const Distortion& distortion, const CameraModel* start = nullptr) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardView& view : views) {
    objects.push_back(on_board(view));
    images.push_back(pixels(view));
  }
  cv::Mat k, d, deviations, of_views_deviations, errors;
  std::vector<cv::Mat> turns, moves;
  int flags = distortion.flags;
  if (start) {
    k = (cv::Mat_<double>(3, 3) << start->fx, 0, start->cx, 0, start->fy, start->cy, 0, 0, 1);
    d = cv::Mat(1, 8, CV_64F, const_cast<double*>(start->distortion.data())).clone();
    d = d.colRange(0, distortion.coefficients > 5 ? 8 : 5).clone();
    flags |= cv::CALIB_USE_INTRINSIC_GUESS;
  }
  IntrinsicsFit fit;
  try {
    fit.rms_px = cv::calibrateCamera(
        objects, images, cv::Size(width, height), k, d, turns, moves, deviations, of_views_deviations, errors,
        flags, cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-9));
  } catch (const cv::Exception& error) {
    return fail(ErrorCode::kInvalid, "the views do not determine the intrinsics: " + error.err);
  }
  fit.model = {width, height, k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2), k.at<double>(1, 2),
               {}};
  d = d.reshape(1, 1);
  for (int i = 0; i < std::min(8, d.cols); ++i) {
    fit.model.distortion[static_cast<std::size_t>(i)] = d.at<double>(i);
  }
  fit.distortion = distortion.used;
  fit.distortion_terms = distortion.coefficients;
  fit.focal_sigma_px = std::max(deviations.at<double>(0), deviations.at<double>(1));
  fit.center_sigma_px = std::max(deviations.at<double>(2), deviations.at<double>(3));
  for (std::size_t i = 0; i < views.size(); ++i) {
    fit.views.push_back(
        {views[i].picture, errors.at<double>(static_cast<int>(i)), pose_of(turns[i], moves[i])});
  }
  return fit;
}

// Chooses the set of coefficients by Schwarz's criterion. The distortion must be valid everywhere
// in the picture.
Result<IntrinsicsFit> fit_best(std::span<const BoardView> views, int width, int height) {
  double numbers = 0;
  for (const BoardView& view : views) numbers += 2 * static_cast<double>(view.pixels.size());
  std::optional<Result<IntrinsicsFit>> best;
  double least = 0;
  for (const Distortion& distortion : kDistortions) {
    // Starting from the smaller set's result keeps fits of wide lenses out of local minima.
    const bool has_start = best && *best;
    auto fit = fit_once(views, width, height, distortion, has_start ? &(*best)->model : nullptr);
    const bool usable = fit && check(fit->model);
    if (best && !usable) continue;
    const double cost = usable ? 2 * numbers * std::log(std::max(1e-6, fit->rms_px)) +
                                     distortion.coefficients * std::log(numbers)
                               : std::numeric_limits<double>::max();
    if (best && cost >= least) continue;
    best = std::move(fit);
    least = cost;
  }
  return *best;
}

// Pixel errors grow with the size of the picture. The factor is 1 up to kUsualWidth.
double size_factor(const CameraModel& model) {
  return std::max(1.0, std::max(model.width, model.height) / kUsualWidth);
}

std::string names_of(std::span<const BoardView> views) {
  constexpr std::size_t kShown = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(kShown, views.size()); ++i) {
    names += (i == 0 ? "" : ", ") + views[i].picture;
  }
  return views.size() > kShown ? names + ", ..." : names;
}

// Describes the two cameras to which the views belong. Empty if there is only one camera.
std::string two_cameras(std::span<const BoardView> views, const IntrinsicsFit& joint) {
  const auto terms = std::find_if(kDistortions.begin(), kDistortions.end(), [&](const Distortion& d) {
    return d.coefficients == joint.distortion_terms;
  });
  const auto fit_group = [&](std::span<const BoardView> group, const CameraModel& start) {
    auto fit = fit_once(group, joint.model.width, joint.model.height, *terms, &start);
    // If the cameras differ much, the joint fit is a bad start.
    auto other = fit_once(group, joint.model.width, joint.model.height, *terms);
    return !fit || (other && other->rms_px < fit->rms_px) ? other : fit;
  };
  const auto split = find_two_cameras(views, joint, fit_group);
  if (!split) return {};
  const auto group = [&](const std::vector<std::size_t>& members, const CameraModel& model) {
    std::vector<BoardView> in_group;
    for (const std::size_t i : members) in_group.push_back(views[i]);
    return fmt::format("{} views ({}) fit a camera of fx {:.0f} and principal point {:.0f}, {:.0f}",
                       members.size(), names_of(in_group), model.fx, model.cx, model.cy);
  };
  return fmt::format(
      "{}, {}: they seem to be of two cameras, or the zoom or focus was changed between them; if all are of "
      "one camera, is the board flat?",
      group(split->first, split->first_model), group(split->second, split->second_model));
}

// The largest angle between two views' boards, degrees.
double most_tilt(const IntrinsicsFit& fit) {
  double least_cosine = 1;
  for (const ViewFit& a : fit.views) {
    for (const ViewFit& b : fit.views) {
      const double cosine = a.camera_from_board.rotation.col(2).dot(b.camera_from_board.rotation.col(2));
      least_cosine = std::min(least_cosine, cosine);
    }
  }
  return std::acos(std::clamp(least_cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

std::string cause_of_uncertainty(const IntrinsicsFit& fit) {
  constexpr double kTilted = 20;
  if (const double tilt = most_tilt(fit); tilt < kTilted) {
    return fmt::format(
        "the board is tilted by {:.0f} degrees at most from view to view: tilt it by 30 to 45 degrees "
        "to all four sides",
        tilt);
  }
  constexpr double kCovered = 0.4;
  if (fit.covered < kCovered) {
    return fmt::format("the board covers only {:.0f} % of the picture: show it nearer, and in all corners",
                       100 * fit.covered);
  }
  return "add views with the board near, tilted by 30 to 45 degrees, and in all corners of the picture";
}

constexpr const char* kUsualCauses =
    "is the board's size as given (a chessboard's in inner corners, a ChArUco board's in squares), is it "
    "flat, are all "
    "pictures of one camera without zoom, and does the lens see less than about 120 degrees";

// Returns the reason why a fit cannot be used, or an empty text.
std::string problem_of(const IntrinsicsFit& fit, std::span<const BoardView> views) {
  const CameraModel& m = fit.model;
  const double factor = size_factor(m);
  const std::size_t bad = fit.dropped.size();
  if (fit.rms_px > kMostRmsPx * factor) {
    return fmt::format("the views do not fit one camera: the error is {:.1f} px, of at most {:.1f}; {}",
                       fit.rms_px, kMostRmsPx * factor, kUsualCauses);
  }
  if (3 * bad > views.size()) {
    return fmt::format("{} of {} views do not fit the camera of the others; {}", bad, views.size(),
                       kUsualCauses);
  }
  if (const auto checked = check(m); !checked) {
    return fmt::format("the views do not determine the intrinsics (error {:.1f} px): {}", fit.rms_px,
                       checked.error().what);
  }
  if (m.cx <= 0 || m.cx >= m.width || m.cy <= 0 || m.cy >= m.height) {
    return fmt::format("the views do not determine the principal point ({:.0f}, {:.0f} was found); {}", m.cx,
                       m.cy, cause_of_uncertainty(fit));
  }
  const double focal = std::min(m.fx, m.fy), size = std::max(m.width, m.height);
  if (!(fit.focal_sigma_px <= kMostFocalSigma * focal)) {
    return fmt::format(
        "the views do not determine the focal length: {:.0f} +- {:.0f} px, of at most +- {:.1f}; {}", m.fx,
        fit.focal_sigma_px, kMostFocalSigma * focal, cause_of_uncertainty(fit));
  }
  if (!(fit.center_sigma_px <= kMostCenterSigma * size)) {
    return fmt::format(
        "the views do not determine the principal point: {:.0f}, {:.0f} +- {:.0f} px, of at most +- {:.1f}; "
        "{}",
        m.cx, m.cy, fit.center_sigma_px, kMostCenterSigma * size, cause_of_uncertainty(fit));
  }
  return {};
}

}  // namespace

double times_good_rms(const IntrinsicsFit& fit) {
  return fit.rms_px / (kGoodRmsPx * size_factor(fit.model));
}

Result<IntrinsicsFit> fit_intrinsics(std::span<const BoardView> views, int width, int height) {
  constexpr double kAnyFieldOfView = 1;  // Any angle would do, since only the picture's size is checked.
  if (const auto usable = check(camera_from_field_of_view(width, height, kAnyFieldOfView)); !usable)
    return fail(usable.error());
  if (views.size() < kFewestViews) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "only {} different, sharp views of the board were found, of at least {}: show it near and "
            "far, tilted, and in every corner of the picture",
            views.size(), kFewestViews));
  }
  auto fit = fit_best(views, width, height);
  if (!fit) return fit;
  std::vector<double> errors;
  for (const ViewFit& view : fit->views) errors.push_back(view.rms_px);
  const double most = std::max(0.2, 3 * median(std::move(errors)));
  std::vector<BoardView> good;
  std::vector<DroppedView> dropped;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (fit->views[i].rms_px <= most) {
      good.push_back(views[i]);
    } else {
      dropped.push_back({views[i].picture, fmt::format("fits badly: {:.2f} px", fit->views[i].rms_px)});
    }
  }
  if (!dropped.empty() && good.size() >= kFewestViews) {
    fit = fit_best(good, width, height);
    if (!fit) return fit;
    fit->dropped = std::move(dropped);
  } else {
    good.assign(views.begin(), views.end());
  }
  fit->covered = covered_share(good, width, height);
  std::string cause = two_cameras(good, *fit);
  double joint_rms_px = fit->rms_px;
  if (cause.empty() && (times_good_rms(*fit) > 1 || !fit->dropped.empty())) {
    // If the cameras differ much, the joint fit may have dropped views or found an odd distortion.
    if (const auto simple = fit_once(views, width, height, kDistortions[1])) {
      cause = two_cameras(views, *simple);
      joint_rms_px = simple->rms_px;
    }
  }
  if (!cause.empty()) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("the views do not fit one camera: the error is {:.2f} px; {}", joint_rms_px, cause));
  }
  if (const std::string problem = problem_of(*fit, views); !problem.empty()) {
    return fail(ErrorCode::kInvalid, problem);
  }
  return fit;
}

Result<ViewFit> locate_board(const BoardView& view, const CameraModel& model) {
  const cv::Matx33d k(model.fx, 0, model.cx, 0, model.fy, model.cy, 0, 0, 1);
  const cv::Mat d(1, 8, CV_64F, const_cast<double*>(model.distortion.data()));
  cv::Mat turn, move;
  try {
    if (!cv::solvePnP(on_board(view), pixels(view), k, d, turn, move)) {
      return fail(ErrorCode::kInvalid, "the board cannot be located in " + view.picture);
    }
  } catch (const cv::Exception&) {
    return fail(ErrorCode::kInvalid, "the board cannot be located in " + view.picture);
  }
  ViewFit fit{view.picture, 0, pose_of(turn, move)};
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Vector3d p =
        fit.camera_from_board * Eigen::Vector3d(view.on_board[i].x(), view.on_board[i].y(), 0);
    if (p.z() <= 0) return fail(ErrorCode::kInvalid, "the board cannot be located in " + view.picture);
    fit.rms_px += (project(model, p) - view.pixels[i]).squaredNorm();
  }
  fit.rms_px = std::sqrt(fit.rms_px / static_cast<double>(view.pixels.size()));
  return fit;
}

}  // namespace copresence::calibrate
