#include "tools/calibrate/lens/lens_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <random>
#include <set>

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

// Sets of distortion coefficients to fit, the smallest first. Too many terms are correlated and extrapolate badly outside
// the corners.
struct Distortion {
  const char* used;
  int flags, coefficients;
};
constexpr std::array<Distortion, 4> kDistortions{
    {{"none", cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3, 0},
     {"k1 k2 p1 p2", cv::CALIB_FIX_K3, 4},
     {"k1 k2 k3 p1 p2", 0, 5},
     {"k1 to k6 p1 p2", cv::CALIB_RATIONAL_MODEL, 8}}};

Result<LensFit> fit_once(std::span<const BoardView> views, int width, int height,
                         const Distortion& distortion) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardView& view : views) {
    objects.push_back(on_board(view));
    images.push_back(pixels(view));
  }
  cv::Mat k, d, deviations, of_views_deviations, errors;
  std::vector<cv::Mat> turns, moves;
  LensFit fit;
  try {
    fit.rms_px = cv::calibrateCamera(
        objects, images, cv::Size(width, height), k, d, turns, moves, deviations, of_views_deviations, errors,
        distortion.flags, cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-9));
  } catch (const cv::Exception& error) {
    return fail(ErrorCode::kInvalid, "the views do not make a lens: " + error.err);
  }
  fit.model = {width, height, k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2), k.at<double>(1, 2),
               {}};
  d = d.reshape(1, 1);
  for (int i = 0; i < std::min(8, d.cols); ++i) {
    fit.model.distortion[static_cast<std::size_t>(i)] = d.at<double>(i);
  }
  fit.distortion = distortion.used;
  fit.focal_sigma_px = std::max(deviations.at<double>(0), deviations.at<double>(1));
  fit.center_sigma_px = std::max(deviations.at<double>(2), deviations.at<double>(3));
  for (std::size_t i = 0; i < views.size(); ++i) {
    fit.views.push_back(
        {views[i].picture, errors.at<double>(static_cast<int>(i)), pose_of(turns[i], moves[i])});
  }
  return fit;
}

// As much distortion as the views can tell: what each coefficient gains must be worth it (Schwarz's criterion), and the
// picture must stay whole.
Result<LensFit> fit_best(std::span<const BoardView> views, int width, int height) {
  double numbers = 0;
  for (const BoardView& view : views) numbers += 2 * static_cast<double>(view.pixels.size());
  std::optional<Result<LensFit>> best;
  double least = 0;
  for (const Distortion& distortion : kDistortions) {
    auto fit = fit_once(views, width, height, distortion);
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

// 1 for pictures of the usual size; errors in pixels grow with larger ones.
double size_factor(const CameraModel& model) {
  return std::max(1.0, std::max(model.width, model.height) / kUsualWidth);
}

// A lens and the views that fit it.
struct Consensus {
  CameraModel model;
  std::vector<std::size_t> views;
};

// The lens that fits most views, and those: from all views, then from random choices of a few. Deterministic.
Consensus largest_consensus(std::span<const BoardView> views, int width, int height, double most_rms_px) {
  constexpr int kChoices = 40;
  constexpr std::size_t kChosen = 3;
  std::mt19937 random(1);
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Consensus best;
  const auto fitting = [&](const CameraModel& model) {
    std::vector<std::size_t> fit;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const auto located = locate_board(views[i], model);
      if (located && located->rms_px <= most_rms_px) fit.push_back(i);
    }
    return fit;
  };
  for (int choice = 0; choice < kChoices && best.views.size() < views.size(); ++choice) {
    std::vector<std::size_t> chosen = order;
    if (choice > 0) {
      std::shuffle(order.begin(), order.end(), random);
      chosen.assign(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(std::min(kChosen, order.size())));
    }
    // A lens from a few views is a guess; one from all that fit the guess is better, and fits more.
    for (int round = 0; round < 3; ++round) {
      std::vector<BoardView> some;
      for (const std::size_t i : chosen) some.push_back(views[i]);
      const auto fit = fit_once(some, width, height, kDistortions[1]);
      if (!fit || !check(fit->model)) break;
      std::vector<std::size_t> there = fitting(fit->model);
      if (there.size() > best.views.size()) best = {fit->model, there};
      if (there.size() == views.size() || (there.size() <= chosen.size() && round > 0)) break;
      chosen = std::move(there);
      if (chosen.size() < kChosen) break;
    }
  }
  return best;
}

std::string names_of(std::span<const BoardView> views) {
  constexpr std::size_t kShown = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(kShown, views.size()); ++i) {
    names += (i == 0 ? "" : ", ") + views[i].picture;
  }
  return views.size() > kShown ? names + ", ..." : names;
}

// Two groups of views, each of which fits a lens of its own. Empty where there are none.
std::string two_cameras(std::span<const BoardView> views, int width, int height, double most_rms_px) {
  constexpr std::size_t kFewest = 3;
  constexpr double kSameFocal = 0.02;  // of focal lengths that are one lens's, found from few views
  const Consensus first = largest_consensus(views, width, height, most_rms_px);
  if (first.views.size() < kFewest) return {};
  std::vector<BoardView> in_first, others;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const bool is_in = std::find(first.views.begin(), first.views.end(), i) != first.views.end();
    (is_in ? in_first : others).push_back(views[i]);
  }
  if (others.size() < kFewest) return {};
  const Consensus second = largest_consensus(others, width, height, most_rms_px);
  if (second.views.size() < kFewest || 2 * second.views.size() < others.size()) return {};
  if (std::abs(first.model.fx / second.model.fx - 1) < kSameFocal) return {};
  std::vector<BoardView> in_second;
  for (const std::size_t i : second.views) in_second.push_back(others[i]);
  return fmt::format(
      "{} views ({}) fit one lens of fx {:.0f}, and {} others ({}) one of fx {:.0f}: they seem to be of two "
      "cameras, "
      "or the zoom or focus was changed between them",
      in_first.size(), names_of(in_first), first.model.fx, in_second.size(), names_of(in_second),
      second.model.fx);
}

// The largest angle between the boards of two views, degrees.
double most_tilt(const LensFit& fit) {
  double least_cosine = 1;
  for (const ViewFit& a : fit.views) {
    for (const ViewFit& b : fit.views) {
      const double cosine = a.camera_from_board.rotation.col(2).dot(b.camera_from_board.rotation.col(2));
      least_cosine = std::min(least_cosine, cosine);
    }
  }
  return std::acos(std::clamp(least_cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

std::string cause_of_uncertainty(const LensFit& fit) {
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

// Why a fit cannot be used; empty where it can.
std::string problem_of(const LensFit& fit, std::span<const BoardView> views) {
  const CameraModel& m = fit.model;
  const double factor = size_factor(m);
  const std::size_t bad = fit.dropped.size();
  const bool is_poor = fit.rms_px > kGoodRmsPx * factor || 4 * bad > views.size();
  if (is_poor) {
    // Poses make up for a part of a wrong focal length, so that two cameras together can seem almost good.
    const double most_rms_px = std::max(0.5 * fit.rms_px, 0.5 * kGoodRmsPx * factor);
    if (const std::string cause = two_cameras(views, m.width, m.height, most_rms_px); !cause.empty()) {
      return fmt::format("the views do not fit one lens: the error is {:.2f} px; {}", fit.rms_px, cause);
    }
  }
  if (fit.rms_px > kMostRmsPx * factor) {
    return fmt::format("the views do not fit one lens: the error is {:.1f} px, of at most {:.1f}; {}",
                       fit.rms_px, kMostRmsPx * factor, kUsualCauses);
  }
  if (3 * bad > views.size()) {
    return fmt::format("{} of {} views do not fit the lens of the others; {}", bad, views.size(),
                       kUsualCauses);
  }
  if (const auto checked = check(m); !checked) {
    return fmt::format("the views do not make a lens (error {:.1f} px): {}", fit.rms_px,
                       checked.error().what);
  }
  if (m.cx <= 0 || m.cx >= m.width || m.cy <= 0 || m.cy >= m.height) {
    return fmt::format("the views do not tell where the picture's middle is ({:.0f}, {:.0f} was found); {}",
                       m.cx, m.cy, cause_of_uncertainty(fit));
  }
  const double focal = std::min(m.fx, m.fy), size = std::max(m.width, m.height);
  if (!(fit.focal_sigma_px <= kMostFocalSigma * focal)) {
    return fmt::format(
        "the views do not tell the focal length: {:.0f} +- {:.0f} px, of at most +- {:.1f}; {}", m.fx,
        fit.focal_sigma_px, kMostFocalSigma * focal, cause_of_uncertainty(fit));
  }
  if (!(fit.center_sigma_px <= kMostCenterSigma * size)) {
    return fmt::format(
        "the views do not tell the principal point: {:.0f}, {:.0f} +- {:.0f} px, of at most +- {:.1f}; {}",
        m.cx, m.cy, fit.center_sigma_px, kMostCenterSigma * size, cause_of_uncertainty(fit));
  }
  return {};
}

}  // namespace

double times_good_rms(const LensFit& fit) {
  return fit.rms_px / (kGoodRmsPx * size_factor(fit.model));
}

Result<LensFit> fit_lens(std::span<const BoardView> views, int width, int height) {
  constexpr double kAnyFieldOfView = 1;  // radians: only the size is in question
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
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  const double most = std::max(0.2, 3 * errors[errors.size() / 2]);
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
