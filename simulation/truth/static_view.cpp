#include "simulation/truth/static_view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// How far the figure reaches from its origin, and its height, in metres.
constexpr float kFigureReach = 0.95f, kFigureHeight = 2.0f;

// Sample points of a pixel's colour. No two sample points share a row or column of sub-pixels.
constexpr int kSampleGrid = 3;
const auto kSamples = [] {
  std::array<Vector2f, kSampleGrid * kSampleGrid> samples;
  for (int i = 0; i < kSampleGrid; ++i) {
    for (int j = 0; j < kSampleGrid; ++j) {
      const int x = kSampleGrid * i + j, y = kSampleGrid * j + kSampleGrid - 1 - i;
      samples[static_cast<std::size_t>(x)] =
          (Vector2f(static_cast<float>(x), static_cast<float>(y)).array() + 0.5f) / samples.size() - 0.5f;
    }
  }
  return samples;
}();

}  // namespace

StaticView::StaticView(std::shared_ptr<const LitScene> scene, const PixelRays& rays)
    : scene_(std::move(scene)) {
  trace(rays);
  find_shadow_blocks(rays);
  light_ = static_light_;
  color_ = view_.color;
}

// Adds the light of the first rays to the pixels from `pixel` on, as far as these rays hit the same
// mesh. Returns how many.
std::size_t StaticView::add_light(std::span<const Ray> rays, float share, std::size_t pixel) {
  std::size_t n = 1;
  while (n < rays.size() && rays[n].mesh == rays[0].mesh) ++n;
  if (rays[0].mesh < 0) return n;
  const auto m = static_cast<std::size_t>(rays[0].mesh);
  const Mesh& mesh = scene_->scene().meshes[m];
  const Material& material = scene_->scene().materials[static_cast<std::size_t>(mesh.material)];
  for (auto* values : {&u_, &v_, &red_, &green_, &blue_}) values->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto& t = mesh.triangles[rays[i].triangle];
    const Vector2f uv =
        interpolate(rays[i], mesh.vertices[t[0]].uv, mesh.vertices[t[1]].uv, mesh.vertices[t[2]].uv);
    u_[i] = uv.x();
    v_[i] = uv.y();
  }
  albedo(material, {u_, v_}, {red_, green_, blue_});
  for (std::size_t i = 0; i < n; ++i) {
    const Light light = reflected_light(rays[i], {red_[i], green_[i], blue_[i]}, true);
    static_light_[pixel + i] += share * light.rest;
    static_lamp_[pixel + i] += share * light.lamp;
  }
  return n;
}

// The light that a surface of colour `color` reflects along a ray that hit it. `rest` is all of
// this light, and `lamp` is the share of the lamp.
Light StaticView::reflected_light(const Ray& ray, const Vector3f& color, bool mirrors) const {
  const auto m = static_cast<std::size_t>(ray.mesh);
  const Mesh& mesh = scene_->scene().meshes[m];
  const Material& material = scene_->scene().materials[static_cast<std::size_t>(mesh.material)];
  Light light;
  if (material.emission > 0) {
    light.rest = color * material.emission;
    return light;
  }
  const auto& t = mesh.triangles[ray.triangle];
  const auto& lights = scene_->light().vertices[m];
  light.lamp = color.cwiseProduct(interpolate(ray, lights[t[0]].lamp, lights[t[1]].lamp, lights[t[2]].lamp));
  light.rest = light.lamp +
               color.cwiseProduct(interpolate(ray, lights[t[0]].rest, lights[t[1]].rest, lights[t[2]].rest));
  if (material.mirror > 0 && mirrors) {
    const SurfacePoint surface = surface_at(mesh, ray);
    const Vector3f incident = ray.direction.normalized();
    const Vector3f normal = surface.normal.dot(incident) > 0 ? Vector3f(-surface.normal) : surface.normal;
    const Vector3f outgoing = incident - 2 * incident.dot(normal) * normal;
    Ray reflection{surface.position + 0.003f * normal, outgoing};
    scene_->background().trace({&reflection, 1});
    Vector3f reflected = Vector3f::Zero();
    if (reflection.mesh >= 0) {
      const Mesh& other = scene_->scene().meshes[static_cast<std::size_t>(reflection.mesh)];
      const Material& other_material = scene_->scene().materials[static_cast<std::size_t>(other.material)];
      reflected =
          reflected_light(reflection, albedo(other_material, surface_at(other, reflection).uv), false).rest;
    }
    light.rest = light.rest * (1 - material.mirror) + material.mirror * reflected;
    light.lamp *= 1 - material.mirror;
  }
  return light;
}

void StaticView::trace(const PixelRays& pixels) {
  view_.depth_m = Image<float>(pixels.model.width, pixels.model.height);
  view_.color = ColorImage(pixels.model.width, pixels.model.height);
  view_.infrared = Image<float>(pixels.model.width, pixels.model.height);
  static_light_.assign(pixels.directions.size(), Vector3f::Zero());
  static_lamp_.assign(pixels.directions.size(), Vector3f::Zero());
  const auto width = static_cast<std::size_t>(pixels.model.width);
  std::vector<Ray> row(width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(pixels.model.height); ++y) {
    const std::size_t start = y * width;
    for (std::size_t x = 0; x < width; ++x) row[x] = Ray{pixels.eye, pixels.directions[start + x]};
    scene_->background().trace(row);
    for (std::size_t x = 0; x < width; ++x) {
      if (row[x].mesh < 0) continue;
      const Mesh& mesh = scene_->scene().meshes[static_cast<std::size_t>(row[x].mesh)];
      const Material& material = scene_->scene().materials[static_cast<std::size_t>(mesh.material)];
      const SurfacePoint surface = surface_at(mesh, row[x]);
      view_.depth_m.data()[start + x] = row[x].far;
      view_.infrared.data()[start + x] =
          material.infrared * std::abs(surface.normal.dot(pixels.directions[start + x].normalized()));
    }
    constexpr float kShare = 1.0f / kSamples.size();
    for (const Vector2f& offset : kSamples) {
      for (std::size_t x = 0; x < width; ++x) {
        row[x] = Ray{pixels.eye, pixels.direction(start + x, offset)};
      }
      scene_->background().trace(row);
      for (std::size_t x = 0; x < width;) x += add_light(std::span(row).subspan(x), kShare, start + x);
    }
    for (std::size_t x = 0; x < width; ++x)
      view_.color.data()[start + x] = to_screen(static_light_[start + x]);
  }
}

// Shadows are soft, so 2x2 pixels share one value. Only blocks that the figure may shade are kept.
void StaticView::find_shadow_blocks(const PixelRays& pixels) {
  const Scene& scene = scene_->scene();
  if (scene_->figure().empty() || scene.lights.empty()) return;
  const Vector3f lamp = scene.lights.front().center, feet = scene_->figure().world_from_figure.translation();
  const Capsule reach{feet - Vector3f(0, kFigureReach, 0),
                      feet - Vector3f(0, kFigureHeight - kFigureReach, 0), kFigureReach};
  ShadowPoints points;
  std::vector<Block> blocks;
  for (int y = 0; y < pixels.model.height; y += 2) {
    for (int x = 0; x < pixels.model.width; x += 2) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels.model.width) +
                     static_cast<std::size_t>(x);
      if (view_.depth_m.data()[i] <= 0 || static_lamp_[i].maxCoeff() <= 0.002f) continue;
      points.add(pixels.eye + view_.depth_m.data()[i] * pixels.directions[i]);
      blocks.push_back({x, y});
    }
  }
  points.aim_at(lamp);
  std::vector<float> hidden(points.size());
  cast_shadows(points, {&reach, 1}, kLampRadius, hidden);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    // cast_shadows() never shades a point inside a capsule, but the figure may shade it.
    const Vector3f position(points.x[i], points.y[i], points.z[i]);
    const bool inside = std::hypot(position.x() - feet.x(), position.z() - feet.z()) < kFigureReach;
    if (hidden[i] <= 0 && !inside) continue;
    blocks_.push_back(blocks[i]);
    shadow_points_.add(position);
  }
  shadow_points_.aim_at(lamp);
  hidden_.assign(blocks_.size(), 0.0f);
}

void StaticView::cast_figure_shadow(std::span<const Capsule> capsules, ColorImage& view) {
  const std::vector<float> before = hidden_;
  cast_shadows(shadow_points_, capsules, kLampRadius, hidden_);
  const auto width = static_cast<std::size_t>(view_.color.width());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (hidden_[i] < 0.004f) hidden_[i] = 0;
    if (hidden_[i] == 0 && before[i] == 0) continue;
    for (const std::size_t row : {std::size_t{0}, std::size_t{1}}) {
      const std::size_t start =
          (static_cast<std::size_t>(blocks_[i].y) + row) * width + static_cast<std::size_t>(blocks_[i].x);
      for (std::size_t p = start; p < start + 2; ++p) {
        light_[p] = static_light_[p] - hidden_[i] * static_lamp_[p];
        color_.data()[p] = to_screen(light_[p]);
        view.data()[p] = color_.data()[p];
      }
    }
  }
}

}  // namespace copresence::simulation
