#include "render_client/moving_surfaces/moving_surfaces.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cmath>
#include <utility>

#include "render_client/renderer/merge_rules.h"

namespace copresence::moving_surfaces {
namespace {

constexpr float kNearestM = 0.1F;  // Points nearer to a camera are not projected.
// Depths at this distance in pixels must agree, too, since depth edges are inaccurate by some pixels.
constexpr int kEdgePixels = 3;
constexpr int kFewestPixels = 200;  // Fewer pixels do not change the order of two cameras.

bool moves_at(const MovingBlocks* moving, int shift, int x, int y) {
  if (!moving || moving->empty()) return false;
  return (*moving)(std::min(x >> shift, moving->width() - 1), std::min(y >> shift, moving->height() - 1)) !=
         0;
}

// Calls visit(x, y) for every pixel of the moving blocks.
template <class Visit>
void for_each_moving(const MovingBlocks& moving, int shift, Visit&& visit) {
  for (int j = 0; j < moving.height(); ++j) {
    for (int i = 0; i < moving.width(); ++i) {
      if (moving(i, j) == 0) continue;
      for (int y = j << shift; y < (j + 1) << shift; ++y) {
        for (int x = i << shift; x < (i + 1) << shift; ++x) visit(x, y);
      }
    }
  }
}

// Projects points of one camera's frame into the picture of another camera. It follows project() of
// common/frame in single precision, which is accurate to a hundredth of a pixel.
class Projection {
 public:
  explicit Projection(const CameraModel& model)
      : focal_(Eigen::Vector2d(model.fx, model.fy).cast<float>()),
        center_(Eigen::Vector2d(model.cx, model.cy).cast<float>()),
        is_distorted_(model.is_distorted()) {
    std::transform(model.distortion.begin(), model.distortion.end(), distortion_.begin(),
                   [](double value) { return static_cast<float>(value); });
  }

  // Requires a point with z > 0.
  Eigen::Vector2f operator()(const Eigen::Vector3f& point) const {
    Eigen::Vector2f ray = point.head<2>() * (1 / point.z());
    if (is_distorted_) ray = distorted(ray);
    return ray.cwiseProduct(focal_) + center_;
  }

 private:
  Eigen::Vector2f distorted(const Eigen::Vector2f& ray) const {
    const auto [k1, k2, p1, p2, k3, k4, k5, k6] = distortion_;
    const float x = ray.x(), y = ray.y(), r2 = ray.squaredNorm();
    const float radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  }

  Eigen::Vector2f focal_, center_;
  bool is_distorted_;
  std::array<float, 8> distortion_{};
};

// One camera's depth image in metres.
class Depths {
 public:
  explicit Depths(const renderer::CameraView& view)
      : depths_(view.frame->depth.data()),
        width_(view.frame->depth.width()),
        height_(view.frame->depth.height()),
        metres_(static_cast<float>(metres_per_unit(view.unit))) {}

  bool contains(const Eigen::Vector2f& pixel) const {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= static_cast<float>(width_ - 1) &&
           pixel.y() <= static_cast<float>(height_ - 1);
  }
  // Returns 0 without depth.
  float at(int x, int y) const { return static_cast<float>(depths_[y * width_ + x]) * metres_; }

  // Whether test(z) holds for the four depths around a pixel.
  template <class Test>
  bool around(int x, int y, Test&& test) const {
    const auto beside = [&](int u, int v) {
      return test(at(std::clamp(u, 0, width_ - 1), std::clamp(v, 0, height_ - 1)));
    };
    return beside(x - kEdgePixels, y) && beside(x + kEdgePixels, y) && beside(x, y - kEdgePixels) &&
           beside(x, y + kEdgePixels);
  }

 private:
  const std::uint16_t* depths_;
  int width_, height_;
  float metres_;
};

}  // namespace

bool capture_together(Instant one, Instant other, double period_s) {
  constexpr double kSameInstantS = 0.005;  // A hand at 2 m/s moves by 1 cm.
  const double apart_s = std::chrono::duration<double>(one - other).count();
  return std::abs(std::remainder(apart_s, period_s)) < kSameInstantS;
}

MovingSurfaces::MovingSurfaces(std::size_t cameras)
    : cameras_(cameras), prefers_lower_(cameras * cameras, true), rays_(cameras) {}

void MovingSurfaces::leave_out(RgbdFrame& frame, std::size_t camera,
                               std::span<const std::optional<CameraMotion>> cameras) {
  assert(camera < cameras_ && cameras.size() == cameras_);
  assert(cameras[camera] && cameras[camera]->view.frame == &frame);
  const CameraMotion& own = *cameras[camera];
  if (!own.moving || own.moving->empty()) return;
  if (!(rays_[camera].model == own.view.model)) rays_[camera] = {own.view.model, rays(own.view.model)};
  verdicts_.resize(frame.depth.width(), frame.depth.height());
  bool order_changed = true;
  while (order_changed) {
    std::fill(verdicts_.pixels().begin(), verdicts_.pixels().end(), Verdict::kKeep);
    order_changed = false;
    for (std::size_t other = 0; other < cameras_; ++other) {
      if (other == camera || !cameras[other]) continue;
      const auto pair = std::min(camera, other) * cameras_ + std::max(camera, other);
      const bool prefers_other = prefers_lower_[pair] == (other < camera);
      const float ratio = compare(own, rays_[camera].by_pixel, *cameras[other], prefers_other);
      // The order changes only with a frame of the camera that becomes the better one. That frame is
      // whole, so the other camera may leave out pixels from its next frame on.
      if (!prefers_other || ratio * kSwitch >= 1) continue;
      prefers_lower_[pair] = !prefers_lower_[pair];
      order_changed = true;
    }
  }
  apply(frame, own);
}

// Sets the verdicts on the moving pixels. Returns the mean quality of the other camera at the pixels
// that both see, relative to the own camera. Returns 1 if there are few such pixels.
float MovingSurfaces::compare(const CameraMotion& own, std::span<const Eigen::Vector2f> rays,
                              const CameraMotion& other, bool prefers_other) {
  const renderer::CameraView &from = own.view, &to = other.view;
  const Rigid3 to_from_from = to.world_from_camera.inverse() * from.world_from_camera;
  const Eigen::Matrix3f rotation = to_from_from.rotation.cast<float>();
  const Eigen::Vector3f translation = to_from_from.translation.cast<float>();
  const Projection project(to.model);
  const Depths near_depths(from), far_depths(to);
  const auto calibration_error = static_cast<float>(from.calibration_error_m + to.calibration_error_m);
  const float own_noise = renderer::uncertainty_per_square(from.noise);
  const float other_noise = renderer::uncertainty_per_square(to.noise);
  const float own_precision = renderer::precision(from.noise),
              other_precision = renderer::precision(to.noise);
  const float bias = prefers_other ? kClearlyBetter : 1 / kClearlyBetter;
  const int width = from.model.width;
  const int other_shift = block_shift(to.model.width);
  Verdict* const verdicts = verdicts_.data();
  float own_quality = 0, other_quality = 0;
  int pixels = 0;
  for_each_moving(*own.moving, block_shift(width), [&](int x, int y) {
    const float z = near_depths.at(x, y);
    if (z == 0) return;
    const Eigen::Vector2f ray = rays[static_cast<std::size_t>(y) * width + x];
    const Eigen::Vector3f point = rotation * Eigen::Vector3f(ray.x() * z, ray.y() * z, z) + translation;
    if (!(point.z() > kNearestM)) return;
    const Eigen::Vector2f pixel = project(point);
    if (!far_depths.contains(pixel)) return;
    const int u = static_cast<int>(pixel.x() + 0.5F), v = static_cast<int>(pixel.y() + 0.5F);
    const float measured = far_depths.at(u, v);
    if (measured == 0) return;
    // The sum of uncertainty_m() of both cameras.
    const float range = own_noise * (z * z) + other_noise * (point.z() * point.z()) + calibration_error;
    const float behind = point.z() - measured;
    if (behind > range) return;  // The other camera sees something nearer.
    const float quality = own_precision / (z * z), others = other_precision / (point.z() * point.z());
    own_quality += quality;
    other_quality += others;
    ++pixels;
    if (others * bias <= quality) return;
    Verdict verdict = Verdict::kKeep;
    if (behind < -range) {
      const float past = point.z() + range;
      const bool is_past =
          far_depths.around(u, v, [past](float there) { return there == 0 || there > past; });
      verdict = is_past ? Verdict::kPast : Verdict::kShare;
    } else if (moves_at(other.moving, other_shift, u, v)) {
      const bool is_same = behind < 0.5F * range && far_depths.around(u, v, [&](float there) {
        return std::abs(there - point.z()) < range;
      });
      verdict = is_same ? Verdict::kSame : Verdict::kShare;
    }
    Verdict& so_far = verdicts[y * width + x];
    so_far = std::max(so_far, verdict);
  });
  return pixels < kFewestPixels ? 1 : other_quality / own_quality;
}

void MovingSurfaces::apply(RgbdFrame& frame, const CameraMotion& own) {
  const int width = frame.depth.width(), height = frame.depth.height();
  const auto limit = static_cast<float>(renderer::inverse_step(own.view.noise) * renderer::kGapSteps *
                                        metres_per_unit(own.view.unit));
  // Whether the pixel (u, v) is drawn and on one surface with a pixel of depth z. Then the pixel of
  // depth z is drawn, too, so that no gap opens between the two cameras.
  const auto continues = [&](int u, int v, int z) {
    if (u < 0 || v < 0 || u >= width || v >= height || verdicts_(u, v) > Verdict::kShare) return false;
    const int beside = frame.depth(u, v);
    return beside > 0 && static_cast<float>(std::abs(beside - z)) <=
                             limit * static_cast<float>(beside) * static_cast<float>(z);
  };
  for_each_moving(*own.moving, block_shift(width), [&](int x, int y) {
    const Verdict verdict = verdicts_(x, y);
    if (verdict == Verdict::kKeep) return;
    std::uint16_t& z = frame.depth(x, y);
    const bool is_drawn = verdict == Verdict::kShare ||
                          (verdict == Verdict::kSame && (continues(x - 1, y, z) || continues(x + 1, y, z) ||
                                                         continues(x, y - 1, z) || continues(x, y + 1, z)));
    if (is_drawn) {
      frame.state(x, y) = DepthState::kFilled;
    } else {
      z = 0;
    }
  });
}

}  // namespace copresence::moving_surfaces
