#include "tools/view_bench/view_error.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace copresence::view_bench {
namespace {

constexpr float kEdgeSteps = 8.0F;      // Smallest step of an edge, in disparity steps of a Kinect.
constexpr float kSameSteps = 4.0F;      // Largest error of a measurement, in disparity steps.
constexpr float kFlatSteps = 1.0F;      // Largest curvature of a flat surface, in disparity steps.
constexpr double kFlatLuma = 6;         // Largest range of the true brightness around a flat seam.
constexpr int kMisalignedPixels = 2;    // Largest misalignment of a camera's colours.
constexpr float kStep = 1.0F / 351.3F;  // A Kinect v1's disparity step, 1/m.

double luma(const Rgb8& p) {
  return 0.299 * p.r + 0.587 * p.g + 0.114 * p.b;
}
double luma(const Rgba8& p) {
  return 0.299 * p.r + 0.587 * p.g + 0.114 * p.b;
}

double squared_difference(const Rgb8& a, const Rgba8& b) {
  const double r = a.r - b.r, g = a.g - b.g, blue = a.b - b.b;
  return r * r + g * g + blue * blue;
}

float inverse(float depth_m) {
  return depth_m > 0 ? 1 / depth_m : 0;
}

// Sets all pixels in a square of `radius` around each set pixel.
Image<std::uint8_t> dilate(const Image<std::uint8_t>& image, int radius) {
  const int width = image.width(), height = image.height();
  Image<std::uint8_t> rows(width, height), result(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int i = std::max(0, x - radius); i <= std::min(width - 1, x + radius); ++i)
        rows(x, y) |= image(i, y);
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int i = std::max(0, y - radius); i <= std::min(height - 1, y + radius); ++i)
        result(x, y) |= rows(x, i);
    }
  }
  return result;
}

// The range of brightness around a pixel. The area exceeds that of a seam by kMisalignedPixels, since
// a colour edge that a camera shows at another place is no seam.
double luma_range(const ColorImage& color, int x, int y) {
  constexpr int kAcross = kSeamPixels + kMisalignedPixels;
  double least = 255, most = 0;
  for (int v = std::max(y - kMisalignedPixels, 0); v <= std::min(y + kMisalignedPixels, color.height() - 1);
       ++v) {
    for (int u = std::max(x - kAcross, 0); u <= std::min(x + kAcross, color.width() - 1); ++u) {
      const double value = luma(color(u, v));
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  return most - least;
}

// How a camera relates to a point of the world.
enum class Sight { kOutside, kInside, kEverSeen };
Sight sight(const ViewVolume& camera, const Eigen::Vector3d& world_point) {
  const Eigen::Vector3d point = camera.world_from_camera.inverse() * world_point;
  if (point.z() < camera.range.near_m || point.z() > camera.range.far_m) return Sight::kOutside;
  const Eigen::Vector2d pixel = project(camera.model, point);
  if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > camera.model.width - 1 ||
      pixel.y() > camera.model.height - 1) {
    return Sight::kOutside;
  }
  if (!camera.farthest_m) return Sight::kInside;
  const float farthest = (*camera.farthest_m)(int(pixel.x() + 0.5), int(pixel.y() + 0.5));
  return std::abs(inverse(farthest) - 1 / point.z()) < kSameSteps * kStep ? Sight::kEverSeen : Sight::kInside;
}

// Difference of each pixel to its four neighbours, which is large at fine detail.
template <class Pixels>
double laplacian(const Pixels& image, int x, int y) {
  return luma(image(x - 1, y)) + luma(image(x + 1, y)) + luma(image(x, y - 1)) + luma(image(x, y + 1)) -
         4 * luma(image(x, y));
}

}  // namespace

TrueEyeView describe_truth(const simulation::TrueView& truth, const renderer::ViewPose& eye,
                           std::span<const ViewVolume> cameras) {
  const int width = truth.color.width(), height = truth.color.height();
  TrueEyeView result{truth.color,
                     truth.depth_m,
                     Image<std::uint8_t>(width, height),
                     Image<std::uint8_t>(width, height),
                     {},
                     Image<std::uint8_t>(width, height),
                     {}};
  Image<std::uint8_t> edges(width, height);
  const auto w = [&](int x, int y) { return inverse(truth.depth_m(x, y)); };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double z = truth.depth_m(x, y);
      if (z > 0) {
        const Eigen::Vector3d ray((x - eye.intrinsics.cx) / eye.intrinsics.fx,
                                  (y - eye.intrinsics.cy) / eye.intrinsics.fy, 1);
        const Eigen::Vector3d point = eye.world_from_eye * Eigen::Vector3d(z * ray);
        Sight best = Sight::kOutside;
        for (const ViewVolume& camera : cameras) best = std::max(best, sight(camera, point));
        result.reachable(x, y) = best != Sight::kOutside;
        result.ever_seen(x, y) = best == Sight::kEverSeen;
      }
      if (x > 0 && std::abs(w(x, y) - w(x - 1, y)) > kEdgeSteps * kStep) edges(x, y) = edges(x - 1, y) = 1;
      if (y > 0 && std::abs(w(x, y) - w(x, y - 1)) > kEdgeSteps * kStep) edges(x, y) = edges(x, y - 1) = 1;
      if (x >= kSeamPixels && x < width - kSeamPixels) {
        const float curvature = w(x - kSeamPixels, y) - 2 * w(x, y) + w(x + kSeamPixels, y);
        result.is_flat(x, y) =
            z > 0 && std::abs(curvature) < kFlatSteps * kStep && luma_range(truth.color, x, y) < kFlatLuma;
      }
    }
  }
  result.at_silhouette = dilate(edges, kSilhouettePixels);
  return result;
}

Image<std::uint8_t> moving_region(const Image<float>& depth_m, const Image<float>& earlier_m) {
  assert(same_shape(depth_m, earlier_m));
  Image<std::uint8_t> changed(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < changed.pixels().size(); ++i) {
    changed.data()[i] =
        std::abs(inverse(depth_m.data()[i]) - inverse(earlier_m.data()[i])) > kSameSteps * kStep;
  }
  return dilate(changed, kMovingPixels);
}

double ViewError::Squares::psnr() const {
  if (samples == 0) return std::numeric_limits<double>::quiet_NaN();
  return 10 * std::log10(255.0 * 255.0 * 3 * static_cast<double>(samples) / std::max(sum, 1e-9));
}

void ViewError::Mean::add(double value) {
  sum += value;
  ++samples;
}

double ViewError::Mean::value() const {
  return samples == 0 ? 0 : sum / static_cast<double>(samples);
}

void ViewError::add(const TrueEyeView& truth, const renderer::MergedView& view, bool is_next) {
  assert(truth.color.width() == view.color.width() && truth.color.height() == view.color.height());
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (!truth.reachable(x, y)) continue;
      const double difference = squared_difference(truth.color(x, y), view.color(x, y));
      const renderer::Origin origin = view.origin(x, y);
      const auto add_to = [&](Squares& squares) {
        squares.sum += difference;
        ++squares.samples;
      };
      add_to(all_);
      if (origin == renderer::Origin::kSeen) add_to(seen_);
      if (origin == renderer::Origin::kRemembered) add_to(remembered_);
      if (origin == renderer::Origin::kExtended) add_to(extended_);
      if (origin != renderer::Origin::kSeen && truth.ever_seen(x, y))
        recalled_.add(origin == renderer::Origin::kRemembered);
      if (truth.at_silhouette(x, y)) add_to(silhouette_);
      if (!truth.is_moving.empty() && truth.is_moving(x, y)) add_to(moving_);
    }
  }
  add_seams(truth, view);
  add_sharpness(truth, view);
  if (is_next && last_color_.width() == view.width) add_flicker(truth, view);
  last_color_ = view.color;
  last_origin_ = view.origin;
  last_truth_ = truth.color;
  ++views_;
}

void ViewError::add_seams(const TrueEyeView& truth, const renderer::MergedView& view) {
  for (int y = 0; y < view.height; ++y) {
    for (int x = kSeamPixels; x + kSeamPixels < view.width; ++x) {
      const int left = view.camera(x, y), right = view.camera(x + 1, y);
      if (left == right || !truth.is_flat(x, y) || !truth.reachable(x, y)) continue;
      const int from = x - kSeamPixels, to = x + kSeamPixels;
      if (view.camera(from, y) != left || view.camera(to, y) != right) continue;
      const auto shows_surface = [&](int at) {
        const float error = inverse(view.depth_m(at, y)) - inverse(truth.depth_m(at, y));
        return view.origin(at, y) == renderer::Origin::kSeen && std::abs(error) < kSameSteps * kStep;
      };
      if (!shows_surface(from) || !shows_surface(x) || !shows_surface(x + 1) || !shows_surface(to)) continue;
      const double step = luma(view.color(to, y)) - luma(view.color(from, y));
      const double true_step = luma(truth.color(to, y)) - luma(truth.color(from, y));
      seams_.add(std::abs(step - true_step));
    }
  }
}

void ViewError::add_flicker(const TrueEyeView& truth, const renderer::MergedView& view) {
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (!truth.reachable(x, y) || view.origin(x, y) == renderer::Origin::kEmpty) continue;
      const Rgb8 now = truth.color(x, y), before = last_truth_(x, y);
      if (now.r != before.r || now.g != before.g || now.b != before.b) continue;
      const double change = std::abs(luma(view.color(x, y)) - luma(last_color_(x, y)));
      flicker_.add(change);
      const renderer::Origin origin = view.origin(x, y);
      if (origin != last_origin_(x, y)) continue;
      if (origin == renderer::Origin::kRemembered) flicker_remembered_.add(change);
      if (origin == renderer::Origin::kExtended) flicker_extended_.add(change);
    }
  }
}

void ViewError::add_sharpness(const TrueEyeView& truth, const renderer::MergedView& view) {
  const auto is_shown = [&](int x, int y) {
    return truth.reachable(x, y) && view.camera(x, y) != renderer::kNoCamera;
  };
  for (int y = 1; y + 1 < view.height; ++y) {
    for (int x = 1; x + 1 < view.width; ++x) {
      if (truth.at_silhouette(x, y) || !is_shown(x, y) || !is_shown(x - 1, y) || !is_shown(x + 1, y) ||
          !is_shown(x, y - 1) || !is_shown(x, y + 1)) {
        continue;
      }
      const double shown = laplacian(view.color, x, y), real = laplacian(truth.color, x, y);
      laplacian_ += shown * shown;
      true_laplacian_ += real * real;
    }
  }
}

ViewScore ViewError::score() const {
  const auto share = [](double part, double whole) { return whole > 0 ? part / whole : 0; };
  ViewScore score;
  score.views = views_;
  const auto percent = [&](const Squares& part) {
    return 100 * share(double(part.samples), double(all_.samples));
  };
  score.seen_percent = percent(seen_);
  score.extended_percent = percent(extended_);
  score.remembered_percent = percent(remembered_);
  score.empty_percent =
      std::max(0.0, 100 - score.seen_percent - score.remembered_percent - score.extended_percent);
  score.recalled_percent = 100 * recalled_.value();
  score.psnr = all_.psnr();
  score.psnr_seen = seen_.psnr();
  score.psnr_remembered = remembered_.psnr();
  score.psnr_extended = extended_.psnr();
  score.psnr_silhouette = silhouette_.psnr();
  score.psnr_moving = moving_.psnr();
  score.flicker = flicker_.value();
  score.flicker_remembered = flicker_remembered_.value();
  score.flicker_extended = flicker_extended_.value();
  score.seam_step = seams_.samples > 0 ? seams_.value() : std::numeric_limits<double>::quiet_NaN();
  score.sharpness = share(laplacian_, true_laplacian_);
  return score;
}

}  // namespace copresence::view_bench
