#include "tools/calibrate/lens/lens_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <optional>
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

// How much of the distortion is fitted, the simplest first. More coefficients than the corners can tell apart stand for
// one another, and go astray where no corner was.
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
  fit.focal_sigma_px = deviations.at<double>(0);
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

}  // namespace

Result<LensFit> fit_lens(std::span<const BoardView> views, int width, int height) {
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
  const CameraModel& model = fit->model;
  const bool is_lens = check(model) && model.cx > 0 && model.cx < width && model.cy > 0 &&
                       model.cy < height && fit->rms_px < 5;
  if (!is_lens) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("the views do not make a lens (error {:.1f} px): is the board's size as given, and is it "
                    "shown tilted as well as straight?",
                    fit->rms_px));
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
