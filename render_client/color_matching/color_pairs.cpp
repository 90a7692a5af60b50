#include "render_client/color_matching/color_pairs.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

namespace copresence::color_matching {
namespace {

constexpr int kDarkest = 8, kBrightest = 247;  // Values outside this range are clipped or noise.
constexpr int kMostContrast = 40;              // Greatest range of a channel within 3 x 3 pixels.
constexpr double kSigmas = 3;

// Returns the mean colour of 3 x 3 pixels. Returns nothing if a pixel lacks measured depth or is
// clipped, or if the pixels differ too much.
std::optional<Eigen::Vector3f> even_color(const RgbdFrame& frame, int x, int y) {
  if (x < 1 || y < 1 || x > frame.depth.width() - 2 || y > frame.depth.height() - 2) return std::nullopt;
  Eigen::Array3i sum = Eigen::Array3i::Zero(), least = Eigen::Array3i::Constant(255),
                 most = Eigen::Array3i::Zero();
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (frame.state(u, v) != DepthState::kMeasured) return std::nullopt;
      const Rgb8 pixel = (*frame.color)(u, v);
      const Eigen::Array3i color(pixel.r, pixel.g, pixel.b);
      sum += color;
      least = least.min(color);
      most = most.max(color);
    }
  }
  if (least.minCoeff() < kDarkest || most.maxCoeff() > kBrightest ||
      (most - least).maxCoeff() > kMostContrast) {
    return std::nullopt;
  }
  return Eigen::Vector3f(sum.cast<float>() / (9 * 255.0F));
}

}  // namespace

std::vector<ColorPair> find_color_pairs(const PosedFrame& from, const PosedFrame& to, int spacing_px) {
  assert(spacing_px >= 1 && from.frame->color && to.frame->color);
  const Rigid3 to_from_from = to.world_from_camera.inverse() * from.world_from_camera;
  const double from_metres = metres_per_unit(from.unit), to_metres = metres_per_unit(to.unit);
  std::vector<ColorPair> pairs;
  for (int y = spacing_px / 2; y < from.model.height; y += spacing_px) {
    for (int x = spacing_px / 2; x < from.model.width; x += spacing_px) {
      const double z = from.frame->depth(x, y) * from_metres;
      if (z <= 0) continue;
      const Eigen::Vector3d point = to_from_from * unproject(from.model, {double(x), double(y)}, z);
      if (!(point.z() > 0.05)) continue;
      const Eigen::Vector2d pixel = project(to.model, point);
      if (!(pixel.x() > 0 && pixel.y() > 0 && pixel.x() < to.model.width - 1 &&
            pixel.y() < to.model.height - 1))
        continue;
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      const double seen = to.frame->depth(u, v) * to_metres;
      const double range = kSigmas * (from.noise.sigma_m(z) + to.noise.sigma_m(point.z())) +
                           from.calibration_error_m + to.calibration_error_m;
      if (seen <= 0 || std::abs(seen - point.z()) > range) continue;
      const auto a = even_color(*from.frame, x, y), b = even_color(*to.frame, u, v);
      if (a && b) pairs.push_back({*a, *b});
    }
  }
  return pairs;
}

}  // namespace copresence::color_matching
