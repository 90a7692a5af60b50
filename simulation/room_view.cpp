#include "simulation/room_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/surface.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kFigureReach = 0.95f, kFigureHeight = 2.0f;  // metres around the place where it stands
// Where in a pixel its colour is looked at: no two in one row or column. The figure is looked at less closely, but every time.
constexpr int kRoomGrid = 3;
const auto kRoomSubPixels = [] {
  std::array<Vector2f, kRoomGrid * kRoomGrid> places;
  for (int i = 0; i < kRoomGrid; ++i) {
    for (int j = 0; j < kRoomGrid; ++j) {
      const int x = kRoomGrid * i + j, y = kRoomGrid * j + kRoomGrid - 1 - i;
      places[static_cast<std::size_t>(x)] =
          (Vector2f(static_cast<float>(x), static_cast<float>(y)).array() + 0.5f) / places.size() - 0.5f;
    }
  }
  return places;
}();

}  // namespace

RoomView::RoomView(std::shared_ptr<const World> world, const Sight& sight) : world_(std::move(world)) {
  trace(sight);
  find_shadow_blocks(sight);
  light_ = still_light_;
  color_ = still_.color;
}

// As many of the rays as met the same mesh as the first, for the pixels from `pixel` on. Returns how many those were.
std::size_t RoomView::add_light(std::span<const Ray> rays, float share, std::size_t pixel) {
  std::size_t n = 1;
  while (n < rays.size() && rays[n].mesh == rays[0].mesh) ++n;
  if (rays[0].mesh < 0) return n;
  const auto m = static_cast<std::size_t>(rays[0].mesh);
  const Mesh& mesh = world_->furnishing().meshes[m];
  const Material& material = world_->furnishing().materials[static_cast<std::size_t>(mesh.material)];
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
    const Light light = light_along(rays[i], {red_[i], green_[i], blue_[i]}, true);
    still_light_[pixel + i] += share * light.rest;
    still_lamp_[pixel + i] += share * light.lamp;
  }
  return n;
}

// What comes from where a ray ended, on a surface of this colour: in `rest` all of it, in `lamp` what the lamp has to do with
// it.
Light RoomView::light_along(const Ray& ray, const Vector3f& color, bool mirrors) const {
  const auto m = static_cast<std::size_t>(ray.mesh);
  const Mesh& mesh = world_->furnishing().meshes[m];
  const Material& material = world_->furnishing().materials[static_cast<std::size_t>(mesh.material)];
  Light light;
  if (material.emission > 0) {
    light.rest = color * material.emission;
    return light;
  }
  const auto& t = mesh.triangles[ray.triangle];
  const auto& lights = world_->light().vertices[m];
  light.lamp = color.cwiseProduct(interpolate(ray, lights[t[0]].lamp, lights[t[1]].lamp, lights[t[2]].lamp));
  light.rest = light.lamp +
               color.cwiseProduct(interpolate(ray, lights[t[0]].rest, lights[t[1]].rest, lights[t[2]].rest));
  if (material.mirror > 0 && mirrors) {
    const Surface surface = surface_at(mesh, ray);
    const Vector3f looking = ray.direction.normalized();
    const Vector3f normal = surface.normal.dot(looking) > 0 ? Vector3f(-surface.normal) : surface.normal;
    const Vector3f away = looking - 2 * looking.dot(normal) * normal;
    Ray reflection{surface.position + 0.003f * normal, away};
    world_->still().trace({&reflection, 1});
    Vector3f reflected = Vector3f::Zero();
    if (reflection.mesh >= 0) {
      const Mesh& met = world_->furnishing().meshes[static_cast<std::size_t>(reflection.mesh)];
      const Material& of = world_->furnishing().materials[static_cast<std::size_t>(met.material)];
      reflected = light_along(reflection, albedo(of, surface_at(met, reflection).uv), false).rest;
    }
    light.rest = light.rest * (1 - material.mirror) + material.mirror * reflected;
    light.lamp *= 1 - material.mirror;
  }
  return light;
}

void RoomView::trace(const Sight& sight) {
  still_.depth_m = Image<float>(sight.model.width, sight.model.height);
  still_.color = ColorImage(sight.model.width, sight.model.height);
  still_.infrared = Image<float>(sight.model.width, sight.model.height);
  still_light_.assign(sight.directions.size(), Vector3f::Zero());
  still_lamp_.assign(sight.directions.size(), Vector3f::Zero());
  const auto width = static_cast<std::size_t>(sight.model.width);
  std::vector<Ray> row(width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(sight.model.height); ++y) {
    const std::size_t start = y * width;
    for (std::size_t x = 0; x < width; ++x) row[x] = Ray{sight.eye, sight.directions[start + x]};
    world_->still().trace(row);
    for (std::size_t x = 0; x < width; ++x) {
      if (row[x].mesh < 0) continue;
      const Mesh& mesh = world_->furnishing().meshes[static_cast<std::size_t>(row[x].mesh)];
      const Material& material = world_->furnishing().materials[static_cast<std::size_t>(mesh.material)];
      const Surface surface = surface_at(mesh, row[x]);
      still_.depth_m.data()[start + x] = row[x].far;
      still_.infrared.data()[start + x] =
          material.infrared * std::abs(surface.normal.dot(sight.directions[start + x].normalized()));
    }
    constexpr float kShare = 1.0f / kRoomSubPixels.size();
    for (const Vector2f& offset : kRoomSubPixels) {
      for (std::size_t x = 0; x < width; ++x) {
        row[x] = Ray{sight.eye, sight.direction(start + x, offset)};
      }
      world_->still().trace(row);
      for (std::size_t x = 0; x < width;) x += add_light(std::span(row).subspan(x), kShare, start + x);
    }
    for (std::size_t x = 0; x < width; ++x)
      still_.color.data()[start + x] = to_screen(still_light_[start + x]);
  }
}

// Shadows are soft, so four pixels share one. Only places count whose way to the lamp passes where the figure
// may be.
void RoomView::find_shadow_blocks(const Sight& sight) {
  const Furnishing& furnishing = world_->furnishing();
  if (world_->figure().empty() || furnishing.lights.empty()) return;
  const Vector3f lamp = furnishing.lights.front().center, feet = world_->figure().place.translation();
  const Capsule reach{feet - Vector3f(0, kFigureReach, 0),
                      feet - Vector3f(0, kFigureHeight - kFigureReach, 0), kFigureReach};
  ShadowPoints points;
  std::vector<Block> blocks;
  for (int y = 0; y < sight.model.height; y += 2) {
    for (int x = 0; x < sight.model.width; x += 2) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(sight.model.width) +
                     static_cast<std::size_t>(x);
      if (still_.depth_m.data()[i] <= 0 || still_lamp_[i].maxCoeff() <= 0.002f) continue;
      points.add(sight.eye + still_.depth_m.data()[i] * sight.directions[i]);
      blocks.push_back({x, y});
    }
  }
  points.aim_at(lamp);
  std::vector<float> hidden(points.size());
  shade(points, {&reach, 1}, kLampRadius, hidden);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    // A place within the reach is never shaded by it in shade()'s sense; the figure may well shade it.
    const Vector3f position(points.x[i], points.y[i], points.z[i]);
    const bool inside = std::hypot(position.x() - feet.x(), position.z() - feet.z()) < kFigureReach;
    if (hidden[i] <= 0 && !inside) continue;
    blocks_.push_back(blocks[i]);
    shadow_points_.add(position);
  }
  shadow_points_.aim_at(lamp);
  hidden_.assign(blocks_.size(), 0.0f);
}

void RoomView::cast_shadows(std::span<const Capsule> capsules, ColorImage& seen) {
  const std::vector<float> before = hidden_;
  shade(shadow_points_, capsules, kLampRadius, hidden_);
  const auto width = static_cast<std::size_t>(still_.color.width());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (hidden_[i] < 0.004f) hidden_[i] = 0;
    if (hidden_[i] == 0 && before[i] == 0) continue;
    for (const std::size_t row : {std::size_t{0}, std::size_t{1}}) {
      const std::size_t start =
          (static_cast<std::size_t>(blocks_[i].y) + row) * width + static_cast<std::size_t>(blocks_[i].x);
      for (std::size_t p = start; p < start + 2; ++p) {
        light_[p] = still_light_[p] - hidden_[i] * still_lamp_[p];
        color_.data()[p] = to_screen(light_[p]);
        seen.data()[p] = color_.data()[p];
      }
    }
  }
}

}  // namespace copresence::simulation
