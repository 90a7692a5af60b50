#include "simulation/figure_rays.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kCell = 8;  // pixels; as many as are traced at once

Ray ray_to(const Vector3f& eye, const Vector3f& direction, float wall) {
  return {eye, direction, 1e-3f, wall > 0 ? wall : 1e30f};
}

}  // namespace

FigureRays::FigureRays(std::shared_ptr<const World> world, const Sight& sight)
    : world_(std::move(world)),
      posed_(world_->parts()),
      cells_((sight.model.width + kCell - 1) / kCell, sight.model.height, 0) {
  bound_parts();
}

// Slices of each part along its limb, each in a sphere.
void FigureRays::bound_parts() {
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
void FigureRays::find_cells(const Sight& sight, std::span<const Eigen::Isometry3f> pose) {
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
void FigureRays::for_each_run(std::size_t width, Visit&& visit) const {
  const int columns = cells_.width();
  for (int y = 0; y < cells_.height(); ++y) {
    const std::uint8_t* row = cells_.row(y).data();
    for (int first = 0; first < columns; ++first) {
      if (!row[first]) continue;
      int end = first;
      while (end < columns && row[end]) ++end;
      const int x = first * kCell, x_end = std::min(end * kCell, static_cast<int>(width));
      visit(static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x),
            static_cast<std::size_t>(x_end - x));
      first = end;
    }
  }
}

void FigureRays::find(const Sight& sight, const Image<float>& walls, std::span<const Eigen::Isometry3f> pose,
                      FigureHits& hits) {
  posed_.pose(pose);
  find_cells(sight, pose);
  for_each_run(sight.width(), [&](std::size_t start, std::size_t count) {
    rays_.clear();
    for (std::size_t i = start; i < start + count; ++i)
      rays_.push_back(ray_to(sight.eye, sight.directions[i], walls.data()[i]));
    posed_.trace(rays_);
    for (std::size_t x = 0; x < rays_.size(); ++x) {
      const Ray& ray = rays_[x];
      if (ray.mesh < 0) continue;
      hits.parts[static_cast<std::size_t>(ray.mesh)].push_back(
          {static_cast<std::uint32_t>(start + x), ray.triangle, ray.far, ray.u, ray.v});
    }
  });
  hits.close();
  rays_.clear();
  for (const std::uint32_t pixel : hits.outline) {
    for (const Eigen::Vector2f& offset : kFigureLooks)
      rays_.push_back(ray_to(sight.eye, sight.direction(pixel, offset), walls.data()[pixel]));
  }
  posed_.trace(rays_);
  hits.looks.resize(hits.outline.size());
  for (std::size_t i = 0; i < rays_.size(); ++i)
    hits.looks[i / kFigureLooks.size()][i % kFigureLooks.size()] = rays_[i].mesh;
}

}  // namespace copresence::simulation
