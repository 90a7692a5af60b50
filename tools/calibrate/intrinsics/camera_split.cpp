#include "tools/calibrate/intrinsics/camera_split.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <random>

namespace copresence::calibrate {
namespace {

constexpr std::ptrdiff_t kSmallestGroup = 3;  // Minimum number of views in a group.
// Two cameras differ if a focal length or principal point differs by more than this share of the
// focal length and this number of standard deviations.
constexpr double kLeastDifference = 0.012, kLeastSigmas = 5;
// If the parameters of a group's views scatter less than this, relative to the corners' noise, the
// group is one camera.
constexpr double kTightScatter = 1.5;
// Minimum distance between the two cameras' parameters, relative to the scatter in a group.
constexpr double kLeastDistance = 130;

// Squared error of one view as a function of a small change of the camera's parameters: squares - 2
// gradient . change + change . information change. The board's pose is eliminated.
struct ViewEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double squares = 0;

  double error(const Eigen::VectorXd& change) const {
    return squares - 2 * gradient.dot(change) + change.dot(information * change);
  }
};

ViewEquations linearize(const BoardView& view, const ViewFit& fit, const CameraModel& model,
                        Eigen::Index parameters) {
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector2d& p : view.on_board) points.emplace_back(p.x(), p.y(), 0);
  cv::Matx33d rotation;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rotation(r, c) = fit.camera_from_board.rotation(r, c);
  }
  cv::Vec3d rotation_vector;
  cv::Rodrigues(rotation, rotation_vector);
  const Eigen::Vector3d& t = fit.camera_from_board.translation;
  const cv::Matx33d k(model.fx, 0, model.cx, 0, model.fy, model.cy, 0, 0, 1);
  const cv::Mat d(1, 8, CV_64F, const_cast<double*>(model.distortion.data()));
  std::vector<cv::Point2d> pixels;
  cv::Mat jacobian;  // Columns: rotation, translation, fx fy, cx cy, distortion.
  cv::projectPoints(points, rotation_vector, cv::Vec3d(t.x(), t.y(), t.z()), k, d, pixels, jacobian);
  constexpr Eigen::Index kPose = 6;
  const auto rows = static_cast<Eigen::Index>(2 * points.size());
  Eigen::MatrixXd by_pose(rows, kPose), by_camera(rows, parameters + 1);  // The last column holds the errors.
  for (Eigen::Index row = 0; row < rows; ++row) {
    const int i = static_cast<int>(row);
    for (int c = 0; c < kPose; ++c) by_pose(row, c) = jacobian.at<double>(i, c);
    for (int c = 0; c < parameters; ++c) by_camera(row, c) = jacobian.at<double>(i, kPose + c);
    const auto corner = static_cast<std::size_t>(row / 2);
    by_camera(row, parameters) = row % 2 == 0 ? view.pixels[corner].x() - pixels[corner].x
                                              : view.pixels[corner].y() - pixels[corner].y;
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> poses(by_pose);
  const Eigen::MatrixXd rest = (poses.householderQ().transpose() * by_camera).bottomRows(rows - kPose).eval();
  const auto camera = rest.leftCols(parameters);
  const auto errors = rest.col(parameters);
  return {camera.transpose() * camera, camera.transpose() * errors, errors.squaredNorm()};
}

using Groups = std::vector<bool>;  // For each view: true if it is in the second group.

// Two changes of the camera's parameters, one for each group of views.
class Mixture {
 public:
  explicit Mixture(std::vector<ViewEquations> views) : views_(std::move(views)) {
    const Eigen::Index size = views_[0].gradient.size();
    prior_ = Eigen::MatrixXd::Zero(size, size);
    // A small group may not determine all coefficients. The prior keeps them near the joint fit.
    for (const ViewEquations& view : views_) prior_ += 0.002 * view.information;
  }

  Eigen::VectorXd solve(const Groups& groups, bool second) const {
    Eigen::MatrixXd information = prior_;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(prior_.rows());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (groups[i] != second) continue;
      information += views_[i].information;
      gradient += views_[i].gradient;
    }
    return information.ldlt().solve(gradient);
  }

  /// Assigns views to the better camera until nothing changes. Returns the sum of squared errors.
  double improve(Groups& groups) const {
    constexpr int kMostRounds = 30;
    double sum = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      const Eigen::VectorXd first = solve(groups, false), second = solve(groups, true);
      const Groups before = groups;
      sum = 0;
      for (std::size_t i = 0; i < views_.size(); ++i) {
        const double error_first = views_[i].error(first), error_second = views_[i].error(second);
        groups[i] = error_second < error_first;
        sum += std::min(error_first, error_second);
      }
      if (groups == before) break;
    }
    return sum;
  }

  /// Finds the best of many starts: all cuts through the views sorted by focal length, then random
  /// groups. Deterministic. Returns the sum of squared errors, or infinity if no start ends with
  /// two groups of a few views each.
  double search(Groups& best) const {
    constexpr std::size_t kRandomStarts = 60;
    const std::size_t count = views_.size();
    std::vector<double> focal_change(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double information = views_[i].information.topLeftCorner<2, 2>().sum();
      focal_change[i] = views_[i].gradient.head<2>().sum() / std::max(information, 1e-9);
    }
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return focal_change[a] < focal_change[b]; });
    std::mt19937 random(1);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t start = 0; start < count + kRandomStarts; ++start) {
      Groups groups(count);
      for (std::size_t i = 0; i < count; ++i)
        groups[order[i]] = start < count ? i >= start : random() % 2 == 1;
      const double sum = improve(groups);
      const auto second = std::count(groups.begin(), groups.end(), true);
      if (std::min(second, static_cast<std::ptrdiff_t>(count) - second) < kSmallestGroup || sum >= least)
        continue;
      least = sum;
      best = std::move(groups);
    }
    return least;
  }

  /// True if the parameters of the two cameras differ much more than those of the views within a
  /// group. Both differences are measured along the line between the two parameter sets, in units
  /// of `variance`, the corners' noise.
  bool is_separate(const Groups& groups, double variance) const {
    const Eigen::VectorXd first = solve(groups, false), way = solve(groups, true) - first;
    double distance = 0, scatter = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const double information = way.dot(views_[i].information * way);
      const double along = way.dot(views_[i].gradient - views_[i].information * first) / information;
      distance += information;
      scatter += information * std::pow(along - (groups[i] ? 1 : 0), 2);
    }
    const double noise = variance * static_cast<double>(views_.size());
    return scatter < kTightScatter * noise || distance > kLeastDistance * scatter;
  }

 private:
  std::vector<ViewEquations> views_;
  Eigen::MatrixXd prior_;
};

double squared_error(const IntrinsicsFit& fit, std::span<const BoardView> views) {
  double corners = 0;
  for (const BoardView& view : views) corners += static_cast<double>(view.pixels.size());
  return fit.rms_px * fit.rms_px * corners;
}

CameraModel changed(CameraModel model, const Eigen::VectorXd& change) {
  const CameraModel before = model;
  model.fx += change[0];
  model.fy += change[1];
  model.cx += change[2];
  model.cy += change[3];
  for (Eigen::Index i = 4; i < change.size(); ++i)
    model.distortion[static_cast<std::size_t>(i - 4)] += change[i];
  // For a large change, the linear solution may have a negative focal length.
  return model.fx > 0 && model.fy > 0 ? model : before;
}

bool differ(const IntrinsicsFit& a, const IntrinsicsFit& b) {
  const auto differs = [focal = std::min(a.model.fx, b.model.fx)](double x, double y, double sigma_x,
                                                                  double sigma_y) {
    const double difference = std::abs(x - y);
    return difference > kLeastDifference * focal && difference > kLeastSigmas * std::hypot(sigma_x, sigma_y);
  };
  return differs(a.model.fx, b.model.fx, a.focal_sigma_px, b.focal_sigma_px) ||
         differs(a.model.fy, b.model.fy, a.focal_sigma_px, b.focal_sigma_px) ||
         differs(a.model.cx, b.model.cx, a.center_sigma_px, b.center_sigma_px) ||
         differs(a.model.cy, b.model.cy, a.center_sigma_px, b.center_sigma_px);
}

}  // namespace

std::optional<CameraSplit> find_two_cameras(std::span<const BoardView> views, const IntrinsicsFit& joint,
                                            const FitGroup& fit_group) {
  if (std::ssize(views) < 2 * kSmallestGroup) return std::nullopt;
  const Eigen::Index parameters = 4 + joint.distortion_terms;
  std::vector<ViewEquations> equations;
  double numbers = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    equations.push_back(linearize(views[i], joint.views[i], joint.model, parameters));
    numbers += 2 * static_cast<double>(views[i].pixels.size());
  }
  const Mixture mixture(std::move(equations));
  Groups groups;
  const double linear_squares = mixture.search(groups);
  if (groups.empty()) return std::nullopt;
  // Schwarz's criterion: two cameras have one more parameter set and one bit per view.
  const double joint_squares = squared_error(joint, views);
  const double price = static_cast<double>(parameters) * std::log(numbers) +
                       2 * std::numbers::ln2 * static_cast<double>(views.size());
  const auto is_worth = [&](double squares) { return numbers * std::log(joint_squares / squares) > price; };
  if (!is_worth(linear_squares)) return std::nullopt;

  CameraSplit split;
  std::vector<BoardView> in_first, in_second;
  for (std::size_t i = 0; i < views.size(); ++i) {
    (groups[i] ? split.second : split.first).push_back(i);
    (groups[i] ? in_second : in_first).push_back(views[i]);
  }
  const auto first = fit_group(in_first, changed(joint.model, mixture.solve(groups, false))),
             second = fit_group(in_second, changed(joint.model, mixture.solve(groups, true)));
  if (!first || !second || !differ(*first, *second)) return std::nullopt;
  if (!is_worth(squared_error(*first, in_first) + squared_error(*second, in_second))) return std::nullopt;
  const double freedoms =
      numbers - 6 * static_cast<double>(views.size()) - 2 * static_cast<double>(parameters);
  if (freedoms < 1 || !mixture.is_separate(groups, linear_squares / freedoms)) return std::nullopt;
  split.first_model = first->model;
  split.second_model = second->model;
  return split;
}

}  // namespace copresence::calibrate
