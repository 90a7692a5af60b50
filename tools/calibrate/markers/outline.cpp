#include "tools/calibrate/markers/outline.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace copresence::calibrate {
namespace {

// Brightness between pixels, their centres at whole coordinates.
double brightness(const Image<std::uint8_t>& picture, const Eigen::Vector2d& at) {
  const int x = std::clamp(static_cast<int>(std::floor(at.x())), 0, picture.width() - 2);
  const int y = std::clamp(static_cast<int>(std::floor(at.y())), 0, picture.height() - 2);
  const double u = at.x() - x, v = at.y() - y;
  const double top = picture(x, y) * (1 - u) + picture(x + 1, y) * u;
  const double bottom = picture(x, y + 1) * (1 - u) + picture(x + 1, y + 1) * u;
  return top * (1 - v) + bottom * v;
}

// How far from `at` along the unit vector `outward` dark turns to light: the middle of the steepest rise.
std::optional<double> edge_along(const Image<std::uint8_t>& picture, const Eigen::Vector2d& at,
                                 const Eigen::Vector2d& outward, double reach) {
  constexpr double kStep = 0.25, kHalfRise = 0.75;
  double best = 12, where = 0, weight = 0, sum = 0;  // of 255: less is noise
  for (double s = -reach; s <= reach; s += kStep) {
    const double rise = brightness(picture, at + (s + kHalfRise) * outward) -
                        brightness(picture, at + (s - kHalfRise) * outward);
    if (rise > best) {
      best = rise;
      where = s;
    }
  }
  if (best <= 12) return std::nullopt;
  for (double s = where - 1.5; s <= where + 1.5; s += kStep) {
    const double rise = std::max(0.0, brightness(picture, at + (s + kHalfRise) * outward) -
                                          brightness(picture, at + (s - kHalfRise) * outward));
    sum += rise * s;
    weight += rise;
  }
  return sum / weight;
}

struct Line {
  Eigen::Vector2d point, direction;
};

// The line through most of the places; the farthest fifth is left out once.
std::optional<Line> fit_line(std::vector<Eigen::Vector2d> places) {
  Line line;
  for (int round = 0; round < 2; ++round) {
    if (places.size() < 4) return std::nullopt;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p : places) mean += p / static_cast<double>(places.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& p : places) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);
    line = {mean, axes.eigenvectors().col(1)};
    const Eigen::Vector2d across = axes.eigenvectors().col(0);
    std::sort(places.begin(), places.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return std::abs(across.dot(a - mean)) < std::abs(across.dot(b - mean));
    });
    places.resize(places.size() - places.size() / 5);
  }
  return line;
}

}  // namespace

bool refine_outline(const Image<std::uint8_t>& picture, std::array<Eigen::Vector2d, 4>& corners) {
  for (int round = 0; round < 3; ++round) {
    std::array<Line, 4> lines;
    const Eigen::Vector2d middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
    for (std::size_t side = 0; side < 4; ++side) {
      const Eigen::Vector2d a = corners[side], along = corners[(side + 1) % 4] - a;
      const double length = along.norm();
      if (length < 6) return false;
      Eigen::Vector2d outward(along.y() / length, -along.x() / length);
      if (outward.dot(a - middle) < 0) outward = -outward;
      // Far enough for a bad first guess, but never over the frame's dark cell or the white rim beyond.
      const double reach = std::min(round == 0 ? 3.5 : 2.0, 0.9 * std::abs(outward.dot(a - middle)) / 3);
      std::vector<Eigen::Vector2d> places;
      const int samples = std::clamp(static_cast<int>(length), 8, 60);
      for (int i = 0; i < samples; ++i) {
        const Eigen::Vector2d at = a + along * (0.1 + 0.8 * (i + 0.5) / samples);
        if (const auto off = edge_along(picture, at, outward, reach)) places.push_back(at + *off * outward);
      }
      const auto line = fit_line(std::move(places));
      if (!line) return false;
      lines[side] = *line;
    }
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Line &p = lines[(corner + 3) % 4], &q = lines[corner];
      Eigen::Matrix2d both;
      both << p.direction, -q.direction;
      if (std::abs(both.determinant()) < 0.05) return false;
      const Eigen::Vector2d crossing = p.point + p.direction * (both.inverse() * (q.point - p.point)).x();
      if ((crossing - corners[corner]).norm() > 10) return false;
      corners[corner] = crossing;
    }
  }
  return true;
}

}  // namespace copresence::calibrate
