#include "simulation/truth/figure_view.h"

#include <algorithm>
#include <cmath>

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr std::size_t kSampleCount = kFigureSamples.size();
// Number of hits drawn at once. The data of this many hits fit into the cache.
constexpr std::size_t kHitBatch = 512;

// Computes the share of a lamp's power that arrives at each point, as if from the lamp's centre.
void falloff(const AreaLight& light, const ShadowPoints& positions, const float* __restrict nx,
             const float* __restrict ny, const float* __restrict nz, std::span<float> shares) {
  const Vector3f front = light.front();
  const float lx = light.center.x(), ly = light.center.y(), lz = light.center.z();
  const float fx = front.x(), fy = front.y(), fz = front.z();
  const float* __restrict px = positions.x.data();
  const float* __restrict py = positions.y.data();
  const float* __restrict pz = positions.z.data();
  float* __restrict share = shares.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const float tx = lx - px[i], ty = ly - py[i], tz = lz - pz[i];
    const float square = std::max(tx * tx + (ty * ty + tz * tz), 0.04f), root = std::sqrt(square);
    const float dx = tx / root, dy = ty / root, dz = tz / root;
    const float facing = nx[i] * dx + (ny[i] * dy + nz[i] * dz);
    const float shining = 0.35f - 0.65f * (fx * dx + (fy * dy + fz * dz));
    share[i] = ((facing > 0) & (shining > 0)) ? facing * shining / square : 0.0f;
  }
}

}  // namespace

FigureView::FigureView(std::shared_ptr<const LitScene> scene, const PixelRays& pixels)
    : scene_(std::move(scene)),
      tracer_(scene_, pixels),
      hits_(pixels.width(), pixels.height(), scene_->figure().parts.size()),
      uv_(pixels.width() * pixels.height(), Vector2f::Zero()),
      light_(pixels.width() * pixels.height(), Vector3f::Zero()) {}

void FigureView::find_points(const Mesh& part, const Eigen::Isometry3f& world_from_part,
                             const PixelRays& pixels, std::span<const Hit> hits) {
  const std::size_t n = hits.size();
  points_.positions.resize(n);
  for (auto* values : {&points_.normal_x, &points_.normal_y, &points_.normal_z, &points_.cosine})
    values->resize(n);
  float* __restrict px = points_.positions.x.data();
  float* __restrict py = points_.positions.y.data();
  float* __restrict pz = points_.positions.z.data();
  float* __restrict nx = points_.normal_x.data();
  float* __restrict ny = points_.normal_y.data();
  float* __restrict nz = points_.normal_z.data();
  float* __restrict cosine = points_.cosine.data();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& t = part.triangles[hits[i].triangle];
    const Vector3f normal = part.vertices[t[0]].normal * (1 - hits[i].u - hits[i].v) +
                            part.vertices[t[1]].normal * hits[i].u + part.vertices[t[2]].normal * hits[i].v;
    nx[i] = normal.x();
    ny[i] = normal.y();
    nz[i] = normal.z();
    const Vector3f& direction = pixels.directions[hits[i].pixel];
    px[i] = direction.x();
    py[i] = direction.y();
    pz[i] = direction.z();
    cosine[i] = hits[i].depth;  // The second loop replaces these depths by cosines.
  }
  const Eigen::Matrix3f rotation = world_from_part.linear();
  const Vector3f eye = pixels.eye;
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const float length = std::sqrt(nx[i] * nx[i] + (ny[i] * ny[i] + nz[i] * nz[i]));
    const float x = nx[i] / length, y = ny[i] / length, z = nz[i] / length;
    const float wx = rotation(0, 0) * x + (rotation(0, 1) * y + rotation(0, 2) * z);
    const float wy = rotation(1, 0) * x + (rotation(1, 1) * y + rotation(1, 2) * z);
    const float wz = rotation(2, 0) * x + (rotation(2, 1) * y + rotation(2, 2) * z);
    const float dx = px[i], dy = py[i], dz = pz[i], depth = cosine[i];
    const float along_ray = (wx * dx + (wy * dy + wz * dz)) / std::sqrt(dx * dx + (dy * dy + dz * dz));
    const float side = along_ray > 0 ? -1.0f : 1.0f;
    nx[i] = side * wx;
    ny[i] = side * wy;
    nz[i] = side * wz;
    cosine[i] = std::abs(along_ray);
    px[i] = eye.x() + depth * dx;
    py[i] = eye.y() + depth * dy;
    pz[i] = eye.z() + depth * dz;
  }
}

// Lamps count as points. The rest of the light is the mean reflected light of the scene, more of it
// from above than from below.
void FigureView::light_points() {
  const std::vector<AreaLight>& lamps = scene_->scene().lights;
  const std::size_t n = points_.positions.size();
  const float* __restrict normal_y = points_.normal_y.data();
  std::vector<float> shares(n);
  for (std::size_t c = 0; c < 3; ++c) {
    point_light_.lamp[c].assign(n, 0.0f);
    point_light_.rest[c].assign(n, 0.0f);
  }
  for (std::size_t k = 0; k < lamps.size(); ++k) {
    falloff(lamps[k], points_.positions, points_.normal_x.data(), points_.normal_y.data(),
            points_.normal_z.data(), shares);
    for (std::size_t c = 0; c < 3; ++c) {
      float* __restrict sum = (k == 0 ? point_light_.lamp : point_light_.rest)[c].data();
      const float* __restrict share = shares.data();
      const float power = lamps[k].power[static_cast<Eigen::Index>(c)];
      for (std::size_t i = 0; i < n; ++i) sum[i] += power * share[i];
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    float* __restrict sum = point_light_.rest[c].data();
    const float reflected = scene_->light().reflected_mean[static_cast<Eigen::Index>(c)];
    for (std::size_t i = 0; i < n; ++i) sum[i] += reflected * (1.0f - 0.25f * normal_y[i]);
  }
}

// The change of texture coordinates from one pixel to the next. `distance` is 1 along a row and the
// width along a column. The change is zero if no neighbour shows the same part.
Vector2f FigureView::uv_change(std::size_t pixel, std::size_t distance) const {
  // In metres. A larger change means that a seam of the texture lies between the pixels.
  constexpr float kSeam = 0.05f;
  const std::size_t next = pixel + distance;
  if (next < uv_.size() && hits_.part_of[next] == hits_.part_of[pixel]) {
    const Vector2f change = uv_[next] - uv_[pixel];
    if (change.squaredNorm() < kSeam * kSeam) return change;
  }
  if (pixel >= distance && hits_.part_of[pixel - distance] == hits_.part_of[pixel]) {
    const Vector2f change = uv_[pixel] - uv_[pixel - distance];
    if (change.squaredNorm() < kSeam * kSeam) return change;
  }
  return Vector2f::Zero();
}

// Computes the texture coordinates of the samples of each hit. The differences to neighbouring
// pixels give the size of a pixel on the surface.
void FigureView::find_samples(std::span<const Hit> hits) {
  const std::size_t n = hits.size();
  sample_u_.resize(n * kSampleCount);
  sample_v_.resize(n * kSampleCount);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t pixel = hits[i].pixel;
    const Vector2f along_row = uv_change(pixel, 1), along_column = uv_change(pixel, hits_.width);
    for (std::size_t k = 0; k < kSampleCount; ++k) {
      const Vector2f uv =
          uv_[pixel] + kFigureSamples[k].x() * along_row + kFigureSamples[k].y() * along_column;
      sample_u_[k * n + i] = uv.x();
      sample_v_[k * n + i] = uv.y();
    }
  }
}

// Light is computed once per pixel, but the pattern per sample, since patterns change faster.
void FigureView::draw_hits(std::size_t part, const Eigen::Isometry3f& world_from_part,
                           std::span<const Hit> hits, const PixelRays& pixels,
                           std::span<const Capsule> capsules, TrueView& view) {
  const Scene& scene = scene_->scene();
  const Mesh& mesh = scene_->figure().parts[part];
  const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
  const std::size_t n = hits.size();
  find_points(mesh, world_from_part, pixels, hits);
  light_points();
  points_.positions.aim_at(scene.lights.empty() ? Vector3f::Zero() : scene.lights.front().center);
  hidden_.resize(n);
  cast_shadows(points_.positions, capsules, kLampRadius, hidden_);
  find_samples(hits);
  for (std::vector<float>& channel : sample_colors_) channel.resize(n * kSampleCount);
  albedo(material, {sample_u_, sample_v_}, {sample_colors_[0], sample_colors_[1], sample_colors_[2]});
  for (std::size_t c = 0; c < 3; ++c) {
    // The light of the n hits is stored in the first n elements.
    float* __restrict color = sample_colors_[c].data();
    const float* __restrict lamp = point_light_.lamp[c].data();
    const float* __restrict rest = point_light_.rest[c].data();
    const float* __restrict hidden = hidden_.data();
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
      float sum = 0;
      for (std::size_t k = 0; k < kSampleCount; ++k) sum += color[k * n + i];
      color[i] = sum / kSampleCount * (rest[i] + (1 - hidden[i]) * lamp[i]);
    }
  }
  screen_.resize(n);
  to_screen({sample_colors_[0], sample_colors_[1], sample_colors_[2]}, screen_);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t pixel = hits[i].pixel;
    light_[pixel] = {sample_colors_[0][i], sample_colors_[1][i], sample_colors_[2][i]};
    view.depth_m.data()[pixel] = hits[i].depth;
    view.infrared.data()[pixel] = material.infrared * points_.cosine[i];
    view.color.data()[pixel] = screen_[i];
  }
}

// Anti-aliasing: each silhouette pixel gets the mean light of its samples.
void FigureView::smooth_silhouette(const StaticView& background, TrueView& view) const {
  // The light of a part comes from the pixel itself, or from a neighbour that shows the part.
  const auto light_of = [&](int part, std::size_t pixel) -> const Vector3f& {
    const auto& part_of = hits_.part_of;
    if (part < 0) return background.light(pixel);
    for (const std::size_t i : {pixel, pixel - 1, pixel + 1, pixel - hits_.width, pixel + hits_.width}) {
      if (part_of[i] == part) return light_[i];
    }
    return part_of[pixel] < 0 ? background.light(pixel) : light_[pixel];
  };
  for (std::size_t k = 0; k < hits_.silhouette.size(); ++k) {
    Vector3f light = Vector3f::Zero();
    for (const int part : hits_.sample_parts[k]) light += light_of(part, hits_.silhouette[k]);
    view.color.data()[hits_.silhouette[k]] = to_screen(light / kSampleCount);
  }
}

void FigureView::erase(const StaticView& background, TrueView& view) {
  for (const auto& [first, count] : hits_.runs) {
    std::copy_n(background.view().depth_m.data() + first, count, view.depth_m.data() + first);
    std::copy_n(background.view().infrared.data() + first, count, view.infrared.data() + first);
    std::copy_n(background.color().data() + first, count, view.color.data() + first);
  }
  hits_.clear();
}

void FigureView::draw(const PixelRays& pixels, const StaticView& background,
                      std::span<const Eigen::Isometry3f> pose, std::span<const Capsule> capsules,
                      TrueView& view) {
  tracer_.find(pixels, background.view().depth_m, pose, hits_);
  const std::vector<Mesh>& parts = scene_->figure().parts;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    for (const Hit& hit : hits_.parts[part]) {
      const auto& t = parts[part].triangles[hit.triangle];
      const std::vector<Vertex>& vertices = parts[part].vertices;
      uv_[hit.pixel] =
          vertices[t[0]].uv * (1 - hit.u - hit.v) + vertices[t[1]].uv * hit.u + vertices[t[2]].uv * hit.v;
    }
  }
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const std::span<const Hit> hits(hits_.parts[part]);
    for (std::size_t first = 0; first < hits.size(); first += kHitBatch)
      draw_hits(part, pose[part], hits.subspan(first, std::min(kHitBatch, hits.size() - first)), pixels,
                capsules, view);
  }
  smooth_silhouette(background, view);
}

}  // namespace copresence::simulation
