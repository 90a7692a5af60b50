#include "common/depth/chroma/spiral_points.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace copresence::depth {
namespace {

constexpr double kFirst = 5.0;     // t of the first point: nearer to the centre, turns would crowd
constexpr double kRadius = 127.0;  // of the last point

constexpr int kMoved = 8;  // codes in U and V together; the points lie 38 apart

double arc_length(double t) {
  return 0.5 * (t * std::sqrt(t * t + 1) + std::asinh(t));
}  // eq. 3.12 with b = 1

// t whose arc length is `length`.
double inverse_arc_length(double length) {
  double low = 0, high = 100;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (arc_length(middle) < length ? low : high) = middle;
  }
  return low;
}

}  // namespace

std::array<ChromaPoint, kSpiralPoints> spiral_points() {
  // Points as far from each other as turns are: 2 pi b.
  const double spacing = 2 * std::numbers::pi;
  const double start = arc_length(kFirst);
  const double last = inverse_arc_length(start + spacing * (kSpiralPoints - 1));
  std::array<ChromaPoint, kSpiralPoints> points{};
  for (int i = 0; i < kSpiralPoints; ++i) {
    const double t = inverse_arc_length(start + spacing * i);
    const double r = kRadius * t / last;
    points[i] = {static_cast<std::uint8_t>(std::lround(128 + r * std::cos(t))),
                 static_cast<std::uint8_t>(std::lround(128 + r * std::sin(t)))};
  }
  return points;
}

std::vector<std::uint8_t> nearest_spiral_point() {
  const auto points = spiral_points();
  std::vector<std::uint8_t> nearest(65536);
  for (int u = 0; u < 256; ++u) {
    for (int v = 0; v < 256; ++v) {
      int least = std::numeric_limits<int>::max();
      for (int i = 0; i < kSpiralPoints; ++i) {
        const int du = u - points[i].u, dv = v - points[i].v, distance = du * du + dv * dv;
        if (distance >= least) continue;
        least = distance;
        const bool off = std::abs(du) + std::abs(dv) > kMoved;
        nearest[u * 256 + v] = static_cast<std::uint8_t>(i | (off ? kOffPoint : 0));
      }
    }
  }
  return nearest;
}

}  // namespace copresence::depth
