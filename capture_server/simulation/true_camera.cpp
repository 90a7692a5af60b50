#include "capture_server/simulation/true_camera.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kLampRadius = 0.2f;
constexpr int kCell = 8;                                     // pixels; as many as are traced at once
constexpr float kFigureReach = 0.95f, kFigureHeight = 2.0f;  // metres around the place where it stands
// Where in a pixel its colour is looked at: no two in one row or column. The room is looked at once, and closer.
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
const std::array<Vector2f, 4> kSubPixels{Vector2f(-0.125f, -0.375f), Vector2f(0.375f, -0.125f),
                                         Vector2f(0.125f, 0.375f), Vector2f(-0.375f, 0.125f)};

struct Surface {
  Vector3f position, normal;
  Vector2f uv;
};

template <class Value>
Value interpolate(const Ray& ray, const Value& a, const Value& b, const Value& c) {
  return a * (1 - ray.u - ray.v) + b * ray.u + c * ray.v;
}

Surface surface_at(const Mesh& mesh, const Ray& ray) {
  const auto& t = mesh.triangles[ray.triangle];
  const Vertex &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  return {interpolate(ray, a.position, b.position, c.position),
          interpolate(ray, a.normal, b.normal, c.normal).normalized(), interpolate(ray, a.uv, b.uv, c.uv)};
}

}  // namespace

Result<TrueCamera> TrueCamera::make(std::shared_ptr<const World> world, const CameraModel& model,
                                    const Rigid3& world_from_camera) {
  if (auto usable = check(model); !usable) return fail(usable.error());
  if (!world_from_camera.is_rigid())
    return fail(ErrorCode::kInvalid, "a camera's pose is no rigid transform");
  return TrueCamera(std::move(world), model, world_from_camera);
}

TrueCamera::TrueCamera(std::shared_ptr<const World> world, const CameraModel& model,
                       const Rigid3& world_from_camera)
    : world_(std::move(world)),
      model_(model),
      world_from_camera_(world_from_camera),
      eye_(world_from_camera.translation.cast<float>()),
      posed_(world_->parts()) {
  const Eigen::Matrix3f turn = world_from_camera.rotation.cast<float>();
  for (const Vector2f& ray : rays(model)) directions_.push_back(turn * Vector3f(ray.x(), ray.y(), 1));
  pixel_x_ = turn.col(0) / static_cast<float>(model.fx);
  pixel_y_ = turn.col(1) / static_cast<float>(model.fy);
  trace_still();
  find_shadow_blocks();
  view_ = still_;
  room_light_ = still_light_;
  room_color_ = still_.color;
  cells_ = Image<std::uint8_t>((model.width + kCell - 1) / kCell, model.height, 0);
  bound_parts();
  part_of_.assign(directions_.size(), -1);
  figure_light_.resize(directions_.size(), Vector3f::Zero());
  figure_uv_.resize(directions_.size(), Vector2f::Zero());
}

Vector3f TrueCamera::still_light(const Ray& ray, const Vector3f& looking, Vector3f& of_lamp,
                                 bool mirrors) const {
  of_lamp.setZero();
  if (ray.mesh < 0) return Vector3f::Zero();
  const auto m = static_cast<std::size_t>(ray.mesh);
  const Mesh& mesh = world_->furnishing().meshes[m];
  const Material& material = world_->furnishing().materials[static_cast<std::size_t>(mesh.material)];
  const Surface surface = surface_at(mesh, ray);
  const Vector3f color = albedo(material, surface.uv);
  if (material.emission > 0) return color * material.emission;

  const auto& t = mesh.triangles[ray.triangle];
  const auto& lights = world_->light().vertices[m];
  of_lamp = color.cwiseProduct(interpolate(ray, lights[t[0]].lamp, lights[t[1]].lamp, lights[t[2]].lamp));
  Vector3f light =
      of_lamp + color.cwiseProduct(interpolate(ray, lights[t[0]].rest, lights[t[1]].rest, lights[t[2]].rest));
  if (material.mirror > 0 && mirrors) {
    const Vector3f normal = surface.normal.dot(looking) > 0 ? Vector3f(-surface.normal) : surface.normal;
    const Vector3f away = looking - 2 * looking.dot(normal) * normal;
    Ray reflection{surface.position + 0.003f * normal, away};
    world_->still().trace({&reflection, 1});
    Vector3f unused;
    light = light * (1 - material.mirror) + material.mirror * still_light(reflection, away, unused, false);
    of_lamp *= 1 - material.mirror;
  }
  return light;
}

void TrueCamera::trace_still() {
  still_.depth_m = Image<float>(model_.width, model_.height);
  still_.color = ColorImage(model_.width, model_.height);
  still_.infrared = Image<float>(model_.width, model_.height);
  still_light_.assign(directions_.size(), Vector3f::Zero());
  still_lamp_.assign(directions_.size(), Vector3f::Zero());
  const auto width = static_cast<std::size_t>(model_.width);
  std::vector<Ray> row(width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(model_.height); ++y) {
    const std::size_t start = y * width;
    for (std::size_t x = 0; x < width; ++x) row[x] = Ray{eye_, directions_[start + x]};
    world_->still().trace(row);
    for (std::size_t x = 0; x < width; ++x) {
      if (row[x].mesh < 0) continue;
      const Mesh& mesh = world_->furnishing().meshes[static_cast<std::size_t>(row[x].mesh)];
      const Material& material = world_->furnishing().materials[static_cast<std::size_t>(mesh.material)];
      const Surface surface = surface_at(mesh, row[x]);
      still_.depth_m.data()[start + x] = row[x].far;
      still_.infrared.data()[start + x] =
          material.infrared * std::abs(surface.normal.dot(directions_[start + x].normalized()));
    }
    constexpr float kShare = 1.0f / kRoomSubPixels.size();
    for (const Vector2f& offset : kRoomSubPixels) {
      for (std::size_t x = 0; x < width; ++x) {
        row[x] = Ray{eye_, directions_[start + x] + offset.x() * pixel_x_ + offset.y() * pixel_y_};
      }
      world_->still().trace(row);
      for (std::size_t x = 0; x < width; ++x) {
        Vector3f of_lamp;
        still_light_[start + x] += kShare * still_light(row[x], row[x].direction.normalized(), of_lamp, true);
        still_lamp_[start + x] += kShare * of_lamp;
      }
    }
    for (std::size_t x = 0; x < width; ++x)
      still_.color.data()[start + x] = to_screen(still_light_[start + x]);
  }
}

// Shadows are soft, so four pixels share one. Only places count whose way to the lamp passes where the figure
// may be.
void TrueCamera::find_shadow_blocks() {
  const Furnishing& furnishing = world_->furnishing();
  if (world_->figure().empty() || furnishing.lights.empty()) return;
  const Vector3f lamp = furnishing.lights.front().center, feet = world_->figure().place.translation();
  const Capsule reach{feet - Vector3f(0, kFigureReach, 0),
                      feet - Vector3f(0, kFigureHeight - kFigureReach, 0), kFigureReach};
  ShadowPoints points;
  std::vector<Block> blocks;
  for (int y = 0; y < model_.height; y += 2) {
    for (int x = 0; x < model_.width; x += 2) {
      const auto i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(model_.width) + static_cast<std::size_t>(x);
      if (still_.depth_m.data()[i] <= 0 || still_lamp_[i].maxCoeff() <= 0.002f) continue;
      points.add(eye_ + still_.depth_m.data()[i] * directions_[i], lamp);
      blocks.push_back({x, y});
    }
  }
  std::vector<float> hidden(points.size());
  shade(points, {&reach, 1}, kLampRadius, hidden);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    // A place within the reach is never shaded by it in shade()'s sense; the figure may well shade it.
    const Vector3f position(points.x[i], points.y[i], points.z[i]);
    const bool inside = std::hypot(position.x() - feet.x(), position.z() - feet.z()) < kFigureReach;
    if (hidden[i] <= 0 && !inside) continue;
    blocks_.push_back(blocks[i]);
    shadow_points_.add(position, lamp);
  }
  hidden_.assign(blocks_.size(), 0.0f);
}

void TrueCamera::cast_shadows(const std::vector<Capsule>& capsules) {
  const std::vector<float> before = hidden_;
  shade(shadow_points_, capsules, kLampRadius, hidden_);
  const auto width = static_cast<std::size_t>(model_.width);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (hidden_[i] < 0.004f) hidden_[i] = 0;
    if (hidden_[i] == 0 && before[i] == 0) continue;
    for (const std::size_t row : {std::size_t{0}, std::size_t{1}}) {
      const std::size_t start =
          (static_cast<std::size_t>(blocks_[i].y) + row) * width + static_cast<std::size_t>(blocks_[i].x);
      for (std::size_t p = start; p < start + 2; ++p) {
        room_light_[p] = still_light_[p] - hidden_[i] * still_lamp_[p];
        room_color_.data()[p] = to_screen(room_light_[p]);
        view_.color.data()[p] = room_color_.data()[p];
      }
    }
  }
}

// Slices of each part along its limb, each in a sphere.
void TrueCamera::bound_parts() {
  constexpr float kSlice = 0.07f;
  for (const Mesh& mesh : world_->figure().parts) {
    std::map<int, std::vector<Vector3f>> slices;
    for (const auto& t : mesh.triangles) {
      const float middle =
          (mesh.vertices[t[0]].position + mesh.vertices[t[1]].position + mesh.vertices[t[2]].position).y() /
          3;
      auto& slice = slices[static_cast<int>(std::floor(middle / kSlice))];
      for (const std::uint32_t vertex : t) slice.push_back(mesh.vertices[vertex].position);
    }
    std::vector<Sphere> spheres;
    for (const auto& [unused, points] : slices) {
      Vector3f low = points.front(), high = points.front();
      for (const Vector3f& point : points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
      }
      Sphere sphere{0.5f * (low + high), 0};
      for (const Vector3f& point : points)
        sphere.radius = std::max(sphere.radius, (point - sphere.center).norm());
      spheres.push_back(sphere);
    }
    bounds_.push_back(std::move(spheres));
  }
}

// A sphere of radius r at depth z shows within about f r / (z - r) pixels of its middle; a tenth more covers
// the lens.
void TrueCamera::find_cells(const std::vector<Eigen::Isometry3f>& pose) {
  std::fill(cells_.pixels().begin(), cells_.pixels().end(), std::uint8_t{0});
  const Rigid3 camera_from_world = world_from_camera_.inverse();
  for (std::size_t part = 0; part < pose.size(); ++part) {
    for (const Sphere& sphere : bounds_[part]) {
      const Eigen::Vector3d center = camera_from_world * Vector3f(pose[part] * sphere.center).cast<double>();
      const double nearest = center.z() - sphere.radius;
      if (center.z() + sphere.radius < 0) continue;
      if (nearest < 0.1) {  // beside or around the eye: it may be anywhere
        std::fill(cells_.pixels().begin(), cells_.pixels().end(), std::uint8_t{1});
        return;
      }
      const Eigen::Vector2d middle = project(model_, center);
      const double rx = 1.1 * sphere.radius * model_.fx / nearest + 2,
                   ry = 1.1 * sphere.radius * model_.fy / nearest + 2;
      const int top = static_cast<int>(std::clamp(middle.y() - ry, 0.0, double(model_.height)));
      const int bottom = static_cast<int>(std::clamp(middle.y() + ry + 1, 0.0, double(model_.height)));
      for (int y = top; y < bottom; ++y) {
        const double off = (y - middle.y()) / ry, half = rx * std::sqrt(std::max(0.0, 1 - off * off));
        const double left = std::clamp(middle.x() - half, 0.0, model_.width - 1.0);
        const double right = std::clamp(middle.x() + half, 0.0, model_.width - 1.0);
        if (middle.x() + half < 0 || middle.x() - half > model_.width - 1) continue;
        for (int cell = static_cast<int>(left) / kCell; cell <= static_cast<int>(right) / kCell; ++cell)
          cells_(cell, y) = 1;
      }
    }
  }
}

// Calls visit(index of the first pixel, number of pixels) for every unbroken run of cells in a row.
template <class Visit>
void TrueCamera::for_each_run(Visit&& visit) const {
  const int columns = cells_.width();
  for (int y = 0; y < model_.height; ++y) {
    const std::uint8_t* row = cells_.row(y).data();
    for (int first = 0; first < columns; ++first) {
      if (!row[first]) continue;
      int end = first;
      while (end < columns && row[end]) ++end;
      const int x = first * kCell, x_end = std::min(end * kCell, model_.width);
      visit(
          static_cast<std::size_t>(y) * static_cast<std::size_t>(model_.width) + static_cast<std::size_t>(x),
          static_cast<std::size_t>(x_end - x));
      first = end;
    }
  }
}

void TrueCamera::draw_figure(const std::vector<Eigen::Isometry3f>& pose,
                             const std::vector<Capsule>& capsules) {
  const Furnishing& furnishing = world_->furnishing();
  std::vector<std::size_t> pixels;
  std::vector<Light> lights;
  std::vector<const Material*> materials;
  ShadowPoints points;
  const Vector3f lamp = furnishing.lights.empty() ? Vector3f::Zero() : furnishing.lights.front().center;
  for_each_run([&](std::size_t start, std::size_t count) {
    rays_.clear();
    for (std::size_t i = start; i < start + count; ++i) {
      const float room = still_.depth_m.data()[i];
      rays_.push_back(Ray{eye_, directions_[i], 1e-3f, room > 0 ? room : 1e30f});
    }
    posed_.trace(rays_);
    for (std::size_t x = 0; x < rays_.size(); ++x) {
      const Ray& ray = rays_[x];
      if (ray.mesh < 0) continue;
      const std::size_t i = start + x;
      const auto part = static_cast<std::size_t>(ray.mesh);
      const Mesh& mesh = world_->figure().parts[part];
      const Material& material = furnishing.materials[static_cast<std::size_t>(mesh.material)];
      const Surface surface = surface_at(mesh, ray);
      Vector3f normal = pose[part].linear() * surface.normal;
      const float facing = normal.dot(ray.direction) / ray.direction.norm();
      if (facing > 0) normal = -normal;
      const Vector3f position = eye_ + ray.far * ray.direction;
      part_of_[i] = static_cast<std::int8_t>(ray.mesh);
      view_.depth_m.data()[i] = ray.far;
      view_.infrared.data()[i] = material.infrared * std::abs(facing);
      figure_uv_[i] = surface.uv;
      pixels.push_back(i);
      materials.push_back(&material);
      lights.push_back(light_at(furnishing, world_->light(), position, normal));
      points.add(position, lamp);
    }
  });
  std::vector<float> hidden(points.size());
  shade(points, capsules, kLampRadius, hidden);
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    const Vector3f color = mean_albedo(*materials[k], pixels[k]);
    const Vector3f light = color.cwiseProduct(lights[k].rest + (1 - hidden[k]) * lights[k].lamp);
    figure_light_[pixels[k]] = light;
    view_.color.data()[pixels[k]] = to_screen(light);
  }
}

// How uv changes over `distance` pixels of the picture's buffer, as far as a neighbour shows the same part.
Vector2f TrueCamera::uv_change(std::size_t pixel, std::size_t distance) const {
  constexpr float kSeam = 0.05f;  // metres; more is the jump from one end of the cloth to the other
  for (const auto& [from, to] : {std::pair{pixel, pixel + distance}, std::pair{pixel - distance, pixel}}) {
    if (from >= part_of_.size() || to >= part_of_.size() || part_of_[from] != part_of_[to]) continue;
    const Vector2f change = figure_uv_[to] - figure_uv_[from];
    if (change.squaredNorm() < kSeam * kSeam) return change;
  }
  return Vector2f::Zero();
}

// A pixel sees an area, not a point. Light changes little within it, cloth does.
Vector3f TrueCamera::mean_albedo(const Material& material, std::size_t pixel) const {
  const Vector2f across = uv_change(pixel, 1),
                 down = uv_change(pixel, static_cast<std::size_t>(model_.width));
  Vector3f sum = Vector3f::Zero();
  for (const Vector2f& offset : kSubPixels) {
    sum += albedo(material, figure_uv_[pixel] + offset.x() * across + offset.y() * down);
  }
  return sum / kSubPixels.size();
}

// Pixels on the outline of a part show the share of each side.
void TrueCamera::smooth_outline() {
  const auto width = static_cast<std::size_t>(model_.width), height = static_cast<std::size_t>(model_.height);
  rays_.clear();
  std::vector<std::size_t> outline;
  const auto around = [&](std::size_t i) { return std::array{i - 1, i + 1, i - width, i + width}; };
  for_each_run([&](std::size_t start, std::size_t count) {
    const std::size_t y = start / width;
    if (y == 0 || y + 1 == height) return;
    for (std::size_t i = std::max(start, y * width + 1); i < std::min(start + count, (y + 1) * width - 1);
         ++i) {
      const auto beside = around(i);
      if (std::all_of(beside.begin(), beside.end(),
                      [&](std::size_t n) { return part_of_[n] == part_of_[i]; }))
        continue;
      outline.push_back(i);
      const float room = still_.depth_m.data()[i];
      for (const Vector2f& offset : kSubPixels) {
        rays_.push_back(Ray{eye_, directions_[i] + offset.x() * pixel_x_ + offset.y() * pixel_y_, 1e-3f,
                            room > 0 ? room : 1e30f});
      }
    }
  });
  posed_.trace(rays_);
  // A part's light at the pixel is that of the nearest pixel that shows it.
  const auto light_of = [&](int part, std::size_t pixel) -> const Vector3f& {
    if (part < 0) return room_light_[pixel];
    if (part_of_[pixel] == part) return figure_light_[pixel];
    for (const std::size_t beside : around(pixel)) {
      if (part_of_[beside] == part) return figure_light_[beside];
    }
    return part_of_[pixel] < 0 ? room_light_[pixel] : figure_light_[pixel];
  };
  for (std::size_t k = 0; k < outline.size(); ++k) {
    Vector3f light = Vector3f::Zero();
    for (std::size_t ray = 0; ray < kSubPixels.size(); ++ray)
      light += light_of(rays_[k * kSubPixels.size() + ray].mesh, outline[k]);
    view_.color.data()[outline[k]] = to_screen(light / kSubPixels.size());
  }
}

const TrueView& TrueCamera::look(double phase) {
  const Figure& figure = world_->figure();
  if (figure.empty()) return view_;
  // What the figure covered last time shows the room again.
  for_each_run([&](std::size_t start, std::size_t count) {
    std::copy_n(still_.depth_m.data() + start, count, view_.depth_m.data() + start);
    std::copy_n(still_.infrared.data() + start, count, view_.infrared.data() + start);
    std::copy_n(room_color_.data() + start, count, view_.color.data() + start);
    std::fill_n(part_of_.begin() + static_cast<std::ptrdiff_t>(start), count, std::int8_t{-1});
  });
  const std::vector<Eigen::Isometry3f> pose = figure.pose(phase);
  std::vector<Capsule> capsules;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const Capsule& capsule = figure.capsules[i];
    capsules.push_back({pose[i] * capsule.from, pose[i] * capsule.to, capsule.radius});
  }
  posed_.pose(pose);
  cast_shadows(capsules);
  find_cells(pose);
  draw_figure(pose, capsules);
  smooth_outline();
  return view_;
}

}  // namespace copresence::simulation
