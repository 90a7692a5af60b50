#include "simulation/figure_raster.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

// Eight pixels of a row at once, in the compiler's own vector types; four looks likewise.
constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
using LookFloats = float __attribute__((vector_size(sizeof(FigureHits::Looks))));
using LookInts = std::int32_t __attribute__((vector_size(sizeof(FigureHits::Looks))));

template <class Vector, class Scalar>
Vector load(const Scalar* from) {
  Vector vector;
  std::memcpy(&vector, from, sizeof(vector));
  return vector;
}
template <class Vector, class Scalar>
void store(Scalar* to, const Vector& vector) {
  std::memcpy(to, &vector, sizeof(vector));
}

constexpr float kNearest = 0.1f;    // metres
constexpr float kThinnest = 1e-4f;  // square pixels; of a thinner triangle only rounding would show
constexpr std::int32_t kNothing = -1;
constexpr int kTriangleBits = 24;

// A triangle in the picture: the weights of its second and third corner, and how near it is, grow evenly.
struct Slope {
  float x = 0, y = 0;
};
struct Plane {
  float x = 0, y = 0, nearness = 0;  // at the first corner
  Slope second, third, nearer;
};

// Where the triangle is nearer than `nearness`, that becomes the triangle's and `seen` becomes `id`. `dx`, `dy`: from the first
// corner. Edges belong to both sides.
template <class Values, class Numbers>
inline void draw(const Plane& plane, const Values& dx, const Values& dy, std::int32_t id, float* nearness,
                 std::int32_t* seen) {
  constexpr float kEdge = 1e-5f;
  const Values u = dx * plane.second.x + dy * plane.second.y, v = dx * plane.third.x + dy * plane.third.y;
  const Values here = plane.nearness + (dx * plane.nearer.x + dy * plane.nearer.y),
               before = load<Values>(nearness);
  const Numbers shows = (u >= -kEdge) & (v >= -kEdge) & (u + v <= 1 + kEdge) & (here > before);
  store(nearness, shows ? here : before);
  const Numbers seen_before = load<Numbers>(seen);
  store(seen, shows ? Numbers{} + id : seen_before);
}

// 1 where the mesh is closed and its triangles turn right as seen from outside (y down), -1 where they turn left, 0 where it
// is open: the back of a closed mesh is never seen.
float outside_of(const Mesh& mesh) {
  using Edge = std::array<float, 6>;
  std::vector<Edge> there, back;
  float volume = 0;
  for (const auto& t : mesh.triangles) {
    const std::array<Vector3f, 3> corner{mesh.vertices[t[0]].position, mesh.vertices[t[1]].position,
                                         mesh.vertices[t[2]].position};
    volume += corner[0].dot(corner[1].cross(corner[2]));
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3f &a = corner[i], &b = corner[(i + 1) % 3];
      if (a == b) continue;
      there.push_back({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()});
      back.push_back({b.x(), b.y(), b.z(), a.x(), a.y(), a.z()});
    }
  }
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  if (there != back) return 0;
  return volume > 0 ? -1.0f : 1.0f;
}

}  // namespace

FigureRaster::FigureRaster(std::shared_ptr<const World> world, const Sight& sight)
    : world_(std::move(world)),
      width_(sight.model.width),
      height_(sight.model.height),
      row_(sight.width() + kLanes),
      nearness_(row_ * sight.height()),
      seen_(nearness_.size(), kNothing),
      on_outline_(nearness_.size(), 0),
      outline_index_(nearness_.size()) {
  for (const Mesh& part : world_->figure().parts) {
    places_.emplace_back(part.vertices.size());
    corners_.emplace_back(part.vertices.size());
    outside_.push_back(outside_of(part));
  }
}

// Returns whether all are before the camera.
bool FigureRaster::place_corners(const Sight& sight, std::span<const Eigen::Isometry3f> pose) {
  const auto fx = static_cast<float>(sight.model.fx), fy = static_cast<float>(sight.model.fy);
  const auto cx = static_cast<float>(sight.model.cx), cy = static_cast<float>(sight.model.cy);
  Corner low{1e9f, 1e9f, 0}, high{-1e9f, -1e9f, 0};
  for (std::size_t part = 0; part < places_.size(); ++part) {
    const Eigen::Isometry3d camera_from_world(sight.world_from_camera.inverse().matrix());
    const Eigen::Isometry3f camera_from_part = (camera_from_world * pose[part].cast<double>()).cast<float>();
    const std::vector<Vertex>& vertices = world_->figure().parts[part].vertices;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vector3f place = camera_from_part * vertices[i].position;
      if (place.z() < kNearest) return false;
      places_[part][i] = place;
      const float nearness = 1 / place.z();
      const Corner corner{fx * place.x() * nearness + cx, fy * place.y() * nearness + cy, nearness};
      corners_[part][i] = corner;
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y), 0};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y), 0};
    }
  }
  const auto pixel = [](float at, int size) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(size)));
  };
  box_ = {pixel(low.x - 1, width_), pixel(low.y - 1, height_), pixel(high.x + 2, width_) - 1,
          pixel(high.y + 2, height_) - 1};
  return true;
}

// Calls visit(part, triangle, its plane, the pixels whose middles are within `margin` of its box).
template <class Visit>
void FigureRaster::for_each_triangle(float margin, Visit&& visit) const {
  for (std::size_t part = 0; part < corners_.size(); ++part) {
    const Corner* corners = corners_[part].data();
    const float outside = outside_[part];
    const auto& triangles = world_->figure().parts[part].triangles;
    for (std::size_t triangle = 0; triangle < triangles.size(); ++triangle) {
      const auto& t = triangles[triangle];
      const Corner a = corners[t[0]], b = corners[t[1]], c = corners[t[2]];
      const float bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
      const float area = bx * cy - by * cx;
      if (area * outside < 0 || std::abs(area) < kThinnest) continue;
      const float low_x = std::min({a.x, b.x, c.x}) - margin, high_x = std::max({a.x, b.x, c.x}) + margin;
      const float low_y = std::min({a.y, b.y, c.y}) - margin, high_y = std::max({a.y, b.y, c.y}) + margin;
      if (high_x < 0 || high_y < 0) continue;
      const Box box{static_cast<int>(std::ceil(std::max(low_x, 0.0f))),
                    static_cast<int>(std::ceil(std::max(low_y, 0.0f))),
                    std::min(static_cast<int>(high_x), width_ - 1),
                    std::min(static_cast<int>(high_y), height_ - 1)};
      if (box.left > box.right || box.top > box.bottom) continue;
      const float share = 1 / area, b_nearer = b.nearness - a.nearness, c_nearer = c.nearness - a.nearness;
      Plane plane{a.x, a.y, a.nearness, {cy * share, -cx * share}, {-by * share, bx * share}, {}};
      plane.nearer = {b_nearer * plane.second.x + c_nearer * plane.third.x,
                      b_nearer * plane.second.y + c_nearer * plane.third.y};
      visit(part, triangle, plane, box);
    }
  }
}

void FigureRaster::draw_middles(const Image<float>& walls) {
  for (int y = box_.top; y <= box_.bottom; ++y) {
    const float* __restrict wall = walls.row(y).data();
    float* __restrict nearness = nearness_.data() + static_cast<std::size_t>(y) * row_;
    for (int x = box_.left; x <= box_.right; ++x) nearness[x] = wall[x] > 0 ? 1 / wall[x] : 0.0f;
    std::fill_n(seen_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row_) + box_.left,
                box_.right - box_.left + 1, kNothing);
  }
  for_each_triangle(0, [&](std::size_t part, std::size_t triangle, const Plane& plane, const Box& box) {
    const auto id = static_cast<std::int32_t>(part << kTriangleBits | triangle);
    const Floats first = Floats{0, 1, 2, 3, 4, 5, 6, 7} + (static_cast<float>(box.left) - plane.x);
    for (int y = box.top; y <= box.bottom; ++y) {
      const Floats dy = Floats{} + (static_cast<float>(y) - plane.y);
      Floats dx = first;
      for (int x = box.left; x <= box.right; x += kLanes, dx += kLanes) {
        const std::size_t at = static_cast<std::size_t>(y) * row_ + static_cast<std::size_t>(x);
        draw<Floats, Ints>(plane, dx, dy, id, nearness_.data() + at, seen_.data() + at);
      }
    }
  });
}

// Where the way through each pixel's middle meets the triangle that is seen there (Moeller and Trumbore, 1997).
void FigureRaster::collect(const Sight& sight, FigureHits& hits) const {
  const auto cx = static_cast<float>(sight.model.cx), cy = static_cast<float>(sight.model.cy);
  const auto fx = static_cast<float>(sight.model.fx), fy = static_cast<float>(sight.model.fy);
  for (int y = box_.top; y <= box_.bottom; ++y) {
    const std::int32_t* seen = seen_.data() + static_cast<std::size_t>(y) * row_;
    for (int x = box_.left; x <= box_.right; ++x) {
      if (seen[x] == kNothing) continue;
      const auto part = static_cast<std::size_t>(seen[x] >> kTriangleBits);
      const auto triangle = static_cast<std::uint32_t>(seen[x]) & ((1u << kTriangleBits) - 1);
      const auto& t = world_->figure().parts[part].triangles[triangle];
      const Vector3f &a = places_[part][t[0]], to_b = places_[part][t[1]] - a, to_c = places_[part][t[2]] - a;
      const Vector3f way((static_cast<float>(x) - cx) / fx, (static_cast<float>(y) - cy) / fy, 1);
      const Vector3f across = way.cross(to_c), along = to_b.cross(a);
      const float share = 1 / to_b.dot(across);
      hits.parts[part].push_back({static_cast<std::uint32_t>(y * width_ + x), triangle,
                                  to_c.dot(along) * share, -a.dot(across) * share, way.dot(along) * share});
    }
  }
}

void FigureRaster::draw_looks(const Image<float>& walls, FigureHits& hits) {
  constexpr std::size_t kLooks = kFigureLooks.size();
  look_nearness_.resize(hits.outline.size() * kLooks);
  hits.looks.resize(hits.outline.size());
  const auto place_of = [&](std::uint32_t pixel) {
    return pixel / static_cast<std::size_t>(width_) * row_ + pixel % static_cast<std::size_t>(width_);
  };
  for (std::size_t k = 0; k < hits.outline.size(); ++k) {
    const float wall = walls.data()[hits.outline[k]];
    std::fill_n(look_nearness_.begin() + static_cast<std::ptrdiff_t>(k * kLooks), kLooks,
                wall > 0 ? 1 / wall : 0.0f);
    hits.looks[k].fill(kNothing);
    on_outline_[place_of(hits.outline[k])] = 1;
    outline_index_[place_of(hits.outline[k])] = static_cast<std::uint32_t>(k);
  }
  LookFloats look_x, look_y;
  for (std::size_t i = 0; i < kLooks; ++i) {
    look_x[i] = kFigureLooks[i].x();
    look_y[i] = kFigureLooks[i].y();
  }
  for_each_triangle(0.375f, [&](std::size_t part, std::size_t, const Plane& plane, const Box& box) {
    for (int y = box.top; y <= box.bottom; ++y) {
      const std::uint8_t* marks = on_outline_.data() + static_cast<std::size_t>(y) * row_;
      const LookFloats dy = look_y + (static_cast<float>(y) - plane.y);
      for (int left = box.left; left <= box.right; left += kLanes) {
        if (load<std::uint64_t>(marks + left) == 0) continue;
        for (int x = left; x <= std::min(left + kLanes - 1, box.right); ++x) {
          if (!marks[x]) continue;
          const std::size_t k =
              outline_index_[static_cast<std::size_t>(y) * row_ + static_cast<std::size_t>(x)];
          const LookFloats dx = look_x + (static_cast<float>(x) - plane.x);
          draw<LookFloats, LookInts>(plane, dx, dy, static_cast<std::int32_t>(part),
                                     look_nearness_.data() + k * kLooks, hits.looks[k].data());
        }
      }
    }
  });
  for (const std::uint32_t pixel : hits.outline) on_outline_[place_of(pixel)] = 0;
}

bool FigureRaster::find(const Sight& sight, const Image<float>& walls,
                        std::span<const Eigen::Isometry3f> pose, FigureHits& hits) {
  if (sight.model.is_distorted() || !place_corners(sight, pose)) return false;
  draw_middles(walls);
  collect(sight, hits);
  hits.close();
  draw_looks(walls, hits);
  return true;
}

}  // namespace copresence::simulation
