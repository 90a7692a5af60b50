#include "capture_server/simulation/figure_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "capture_server/simulation/surface.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kCell = 8;  // pixels; as many as are traced at once
// Where in a pixel its colour is looked at: no two in one row or column.
const std::array<Vector2f, 4> kSubPixels{Vector2f(-0.125f, -0.375f), Vector2f(0.375f, -0.125f),
                                         Vector2f(0.125f, 0.375f), Vector2f(-0.375f, 0.125f)};

}  // namespace

FigureView::FigureView(std::shared_ptr<const World> world, const Sight& sight)
    : world_(std::move(world)),
      posed_(world_->parts()),
      width_(sight.width()),
      height_(sight.height()),
      cells_((sight.model.width + kCell - 1) / kCell, sight.model.height, 0),
      part_of_(width_ * height_, -1),
      figure_light_(width_ * height_, Vector3f::Zero()),
      figure_uv_(width_ * height_, Vector2f::Zero()) {
  bound_parts();
}

// Slices of each part along its limb, each in a sphere.
void FigureView::bound_parts() {
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
void FigureView::find_cells(const Sight& sight, std::span<const Eigen::Isometry3f> pose) {
  std::fill(cells_.pixels().begin(), cells_.pixels().end(), std::uint8_t{0});
  const Rigid3 camera_from_world = sight.world_from_camera.inverse();
  for (std::size_t part = 0; part < pose.size(); ++part) {
    for (const Sphere& sphere : bounds_[part]) {
      const Eigen::Vector3d center = camera_from_world * Vector3f(pose[part] * sphere.center).cast<double>();
      const double nearest = center.z() - sphere.radius;
      if (center.z() + sphere.radius < 0) continue;
      if (nearest < 0.1) {  // beside or around the eye: it may be anywhere
        std::fill(cells_.pixels().begin(), cells_.pixels().end(), std::uint8_t{1});
        return;
      }
      const Eigen::Vector2d middle = project(sight.model, center);
      const double rx = 1.1 * sphere.radius * sight.model.fx / nearest + 2,
                   ry = 1.1 * sphere.radius * sight.model.fy / nearest + 2;
      const int top = static_cast<int>(std::clamp(middle.y() - ry, 0.0, double(sight.model.height)));
      const int bottom = static_cast<int>(std::clamp(middle.y() + ry + 1, 0.0, double(sight.model.height)));
      for (int y = top; y < bottom; ++y) {
        const double off = (y - middle.y()) / ry, half = rx * std::sqrt(std::max(0.0, 1 - off * off));
        const double left = std::clamp(middle.x() - half, 0.0, sight.model.width - 1.0);
        const double right = std::clamp(middle.x() + half, 0.0, sight.model.width - 1.0);
        if (middle.x() + half < 0 || middle.x() - half > sight.model.width - 1) continue;
        for (int cell = static_cast<int>(left) / kCell; cell <= static_cast<int>(right) / kCell; ++cell)
          cells_(cell, y) = 1;
      }
    }
  }
}

// Calls visit(index of the first pixel, number of pixels) for every unbroken run of cells in a row.
template <class Visit>
void FigureView::for_each_run(Visit&& visit) const {
  const int columns = cells_.width();
  for (int y = 0; y < cells_.height(); ++y) {
    const std::uint8_t* row = cells_.row(y).data();
    for (int first = 0; first < columns; ++first) {
      if (!row[first]) continue;
      int end = first;
      while (end < columns && row[end]) ++end;
      const int x = first * kCell, x_end = std::min(end * kCell, static_cast<int>(width_));
      visit(static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x),
            static_cast<std::size_t>(x_end - x));
      first = end;
    }
  }
}

void FigureView::draw_parts(const Sight& sight, const RoomView& room, std::span<const Eigen::Isometry3f> pose,
                            std::span<const Capsule> capsules, TrueView& view) {
  const Furnishing& furnishing = world_->furnishing();
  std::vector<std::size_t> pixels;
  std::vector<Light> lights;
  std::vector<const Material*> materials;
  ShadowPoints points;
  const Vector3f lamp = furnishing.lights.empty() ? Vector3f::Zero() : furnishing.lights.front().center;
  for_each_run([&](std::size_t start, std::size_t count) {
    rays_.clear();
    for (std::size_t i = start; i < start + count; ++i) {
      const float wall = room.still().depth_m.data()[i];
      rays_.push_back(Ray{sight.eye, sight.directions[i], 1e-3f, wall > 0 ? wall : 1e30f});
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
      const Vector3f position = sight.eye + ray.far * ray.direction;
      part_of_[i] = static_cast<std::int8_t>(ray.mesh);
      view.depth_m.data()[i] = ray.far;
      view.infrared.data()[i] = material.infrared * std::abs(facing);
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
    view.color.data()[pixels[k]] = to_screen(light);
  }
}

// How uv changes over `distance` pixels of the picture's buffer, as far as a neighbour shows the same part.
Vector2f FigureView::uv_change(std::size_t pixel, std::size_t distance) const {
  constexpr float kSeam = 0.05f;  // metres; more is the jump from one end of the cloth to the other
  for (const auto& [from, to] : {std::pair{pixel, pixel + distance}, std::pair{pixel - distance, pixel}}) {
    if (from >= part_of_.size() || to >= part_of_.size() || part_of_[from] != part_of_[to]) continue;
    const Vector2f change = figure_uv_[to] - figure_uv_[from];
    if (change.squaredNorm() < kSeam * kSeam) return change;
  }
  return Vector2f::Zero();
}

// A pixel sees an area, not a point. Light changes little within it, cloth does.
Vector3f FigureView::mean_albedo(const Material& material, std::size_t pixel) const {
  const Vector2f across = uv_change(pixel, 1), down = uv_change(pixel, width_);
  Vector3f sum = Vector3f::Zero();
  for (const Vector2f& offset : kSubPixels) {
    sum += albedo(material, figure_uv_[pixel] + offset.x() * across + offset.y() * down);
  }
  return sum / kSubPixels.size();
}

// Pixels on the outline of a part show the share of each side.
void FigureView::smooth_outline(const Sight& sight, const RoomView& room, TrueView& view) {
  const std::size_t width = width_, height = height_;
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
      const float wall = room.still().depth_m.data()[i];
      for (const Vector2f& offset : kSubPixels) {
        rays_.push_back(Ray{sight.eye, sight.direction(i, offset), 1e-3f, wall > 0 ? wall : 1e30f});
      }
    }
  });
  posed_.trace(rays_);
  // A part's light at the pixel is that of the nearest pixel that shows it.
  const auto light_of = [&](int part, std::size_t pixel) -> const Vector3f& {
    if (part < 0) return room.light(pixel);
    if (part_of_[pixel] == part) return figure_light_[pixel];
    for (const std::size_t beside : around(pixel)) {
      if (part_of_[beside] == part) return figure_light_[beside];
    }
    return part_of_[pixel] < 0 ? room.light(pixel) : figure_light_[pixel];
  };
  for (std::size_t k = 0; k < outline.size(); ++k) {
    Vector3f light = Vector3f::Zero();
    for (std::size_t ray = 0; ray < kSubPixels.size(); ++ray)
      light += light_of(rays_[k * kSubPixels.size() + ray].mesh, outline[k]);
    view.color.data()[outline[k]] = to_screen(light / kSubPixels.size());
  }
}

void FigureView::erase(const RoomView& room, TrueView& view) {
  for_each_run([&](std::size_t start, std::size_t count) {
    std::copy_n(room.still().depth_m.data() + start, count, view.depth_m.data() + start);
    std::copy_n(room.still().infrared.data() + start, count, view.infrared.data() + start);
    std::copy_n(room.color().data() + start, count, view.color.data() + start);
    std::fill_n(part_of_.begin() + static_cast<std::ptrdiff_t>(start), count, std::int8_t{-1});
  });
}

void FigureView::draw(const Sight& sight, const RoomView& room, std::span<const Eigen::Isometry3f> pose,
                      std::span<const Capsule> capsules, TrueView& view) {
  posed_.pose(pose);
  find_cells(sight, pose);
  draw_parts(sight, room, pose, capsules, view);
  smooth_outline(sight, room, view);
}

}  // namespace copresence::simulation
