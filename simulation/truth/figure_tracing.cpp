#include "simulation/truth/figure_tracing.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kCell = 8;  // In pixels. One packet of rays covers a cell.

Ray ray_to(const Vector3f& eye, const Vector3f& direction, float background) {
  return {eye, direction, 1e-3f, background > 0 ? background : 1e30f};
}

}  // namespace

FigureHits::FigureHits(std::size_t picture_width, std::size_t picture_height, std::size_t part_count)
    : width(picture_width), height(picture_height), parts(part_count), part_of(width * height, -1) {}

void FigureHits::clear() {
  for (const Run& run : runs)
    std::fill_n(part_of.begin() + static_cast<std::ptrdiff_t>(run.first), run.count, std::int8_t{-1});
  for (std::vector<Hit>& part : parts) part.clear();
  runs.clear();
  silhouette.clear();
  sample_parts.clear();
}

void FigureHits::close() {
  std::vector<std::size_t> first(height, width), last(height, 0);  // Per row.
  for (std::size_t part = 0; part < parts.size(); ++part) {
    for (const Hit& hit : parts[part]) {
      part_of[hit.pixel] = static_cast<std::int8_t>(part);
      const std::size_t y = hit.pixel / width, x = hit.pixel % width;
      first[y] = std::min(first[y], x);
      last[y] = std::max(last[y], x);
    }
  }
  std::vector<std::uint8_t> differs(width);
  for (std::size_t y = 0; y < height; ++y) {
    // The pixels next to a silhouette change, too.
    const std::size_t above = y - (y > 0), below = y + (y + 1 < height);
    std::size_t left = std::min({first[above], first[y], first[below]}),
                right = std::max({last[above], last[y], last[below]});
    if (left > right) continue;
    left -= left > 0;
    right += right + 1 < width;
    runs.push_back({y * width + left, right + 1 - left});
    if (y == 0 || y + 1 == height) continue;
    const std::int8_t* __restrict row = part_of.data() + y * width;
    std::uint8_t* __restrict found = differs.data();
    const std::size_t begin = std::max<std::size_t>(left, 1), end = std::min(right + 1, width - 1);
    for (std::size_t x = begin; x < end; ++x) {
      found[x] = static_cast<std::uint8_t>((row[x] ^ row[x - 1]) | (row[x] ^ row[x + 1]) |
                                           (row[x] ^ *(row + x - width)) | (row[x] ^ row[x + width]));
    }
    for (std::size_t x = begin; x < end; ++x) {
      if (found[x]) silhouette.push_back(static_cast<std::uint32_t>(y * width + x));
    }
  }
}

FigureTracer::FigureTracer(std::shared_ptr<const LitScene> scene, const PixelRays& pixels)
    : scene_(std::move(scene)),
      posed_(scene_->figure_parts()),
      cells_((pixels.model.width + kCell - 1) / kCell, pixels.model.height, 0) {
  bound_parts();
}

// Cuts each part into slices along y and puts a sphere around each slice.
void FigureTracer::bound_parts() {
  constexpr float kSlice = 0.07f;
  for (const Mesh& mesh : scene_->figure().parts) {
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

// Marks the cells that the spheres cover. A sphere of radius r at depth z projects to within about
// f r / (z - r) pixels of its centre, where f is the focal length. A tenth is added for distortion.
void FigureTracer::find_cells(const PixelRays& pixels, std::span<const Eigen::Isometry3f> pose) {
  std::fill(cells_.pixels().begin(), cells_.pixels().end(), std::uint8_t{0});
  const Rigid3 camera_from_world = pixels.world_from_camera.inverse();
  for (std::size_t part = 0; part < pose.size(); ++part) {
    for (const Sphere& sphere : bounds_[part]) {
      const Eigen::Vector3d center = camera_from_world * Vector3f(pose[part] * sphere.center).cast<double>();
      const double nearest = center.z() - sphere.radius;
      if (center.z() + sphere.radius < 0) continue;
      if (nearest < 0.1) {  // Next to the eye, a part may cover any pixel.
        std::fill(cells_.pixels().begin(), cells_.pixels().end(), std::uint8_t{1});
        return;
      }
      const Eigen::Vector2d middle = project(pixels.model, center);
      const double rx = 1.1 * sphere.radius * pixels.model.fx / nearest + 2,
                   ry = 1.1 * sphere.radius * pixels.model.fy / nearest + 2;
      const int top = static_cast<int>(std::clamp(middle.y() - ry, 0.0, double(pixels.model.height)));
      const int bottom = static_cast<int>(std::clamp(middle.y() + ry + 1, 0.0, double(pixels.model.height)));
      for (int y = top; y < bottom; ++y) {
        const double off = (y - middle.y()) / ry, half = rx * std::sqrt(std::max(0.0, 1 - off * off));
        const double left = std::clamp(middle.x() - half, 0.0, pixels.model.width - 1.0);
        const double right = std::clamp(middle.x() + half, 0.0, pixels.model.width - 1.0);
        if (middle.x() + half < 0 || middle.x() - half > pixels.model.width - 1) continue;
        for (int cell = static_cast<int>(left) / kCell; cell <= static_cast<int>(right) / kCell; ++cell)
          cells_(cell, y) = 1;
      }
    }
  }
}

// Calls visit(index of the first pixel, number of pixels) for each run of adjacent cells in a row.
template <class Visit>
void FigureTracer::for_each_run(std::size_t width, Visit&& visit) const {
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

void FigureTracer::find(const PixelRays& pixels, const Image<float>& background,
                        std::span<const Eigen::Isometry3f> pose, FigureHits& hits) {
  posed_.pose(pose);
  find_cells(pixels, pose);
  for_each_run(pixels.width(), [&](std::size_t start, std::size_t count) {
    rays_.clear();
    for (std::size_t i = start; i < start + count; ++i)
      rays_.push_back(ray_to(pixels.eye, pixels.directions[i], background.data()[i]));
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
  for (const std::uint32_t pixel : hits.silhouette) {
    for (const Eigen::Vector2f& offset : kFigureSamples)
      rays_.push_back(ray_to(pixels.eye, pixels.direction(pixel, offset), background.data()[pixel]));
  }
  posed_.trace(rays_);
  hits.sample_parts.resize(hits.silhouette.size());
  for (std::size_t i = 0; i < rays_.size(); ++i)
    hits.sample_parts[i / kFigureSamples.size()][i % kFigureSamples.size()] = rays_[i].mesh;
}

}  // namespace copresence::simulation
