#include "simulation/figure_view.h"

#include <algorithm>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kLooks = kFigureLooks.size();
constexpr std::size_t kTogether =
    512;  // hits drawn at once: all that is known of them fits into a core's cache

}  // namespace

FigureView::FigureView(std::shared_ptr<const World> world, const Sight& sight)
    : world_(std::move(world)),
      rays_(world_, sight),
      raster_(world_, sight),
      hits_(sight.width(), sight.height(), world_->figure().parts.size()),
      pattern_(sight.width() * sight.height(), Eigen::Vector2f::Zero()),
      light_(sight.width() * sight.height(), Vector3f::Zero()) {}

// Light changes little within a pixel, cloth does.
void FigureView::draw_some(std::size_t part, const Eigen::Isometry3f& world_from_part,
                           std::span<const Hit> hits, const Sight& sight, std::span<const Capsule> capsules,
                           TrueView& view) {
  const Furnishing& furnishing = world_->furnishing();
  const Mesh& mesh = world_->figure().parts[part];
  const Material& material = furnishing.materials[static_cast<std::size_t>(mesh.material)];
  const std::size_t n = hits.size();
  find_surface(mesh, world_from_part, sight, hits, surface_);
  light_at(furnishing, world_->light(), surface_.points, surface_light_);
  surface_.points.places.aim_at(furnishing.lights.empty() ? Vector3f::Zero()
                                                          : furnishing.lights.front().center);
  hidden_.resize(n);
  shade(surface_.points.places, capsules, kLampRadius, hidden_);
  spread_looks(hits_, hits, pattern_, look_u_, look_v_);
  for (std::vector<float>& channel : look_colors_) channel.resize(n * kLooks);
  albedo(material, {look_u_, look_v_}, {look_colors_[0], look_colors_[1], look_colors_[2]});
  for (std::size_t c = 0; c < 3; ++c) {
    float* __restrict color = look_colors_[c].data();  // its first n become light
    const float* __restrict lamp = surface_light_.lamp[c].data();
    const float* __restrict rest = surface_light_.rest[c].data();
    const float* __restrict hidden = hidden_.data();
#pragma GCC ivdep
    for (std::size_t i = 0; i < n; ++i) {
      float sum = 0;
      for (std::size_t look = 0; look < kLooks; ++look) sum += color[look * n + i];
      color[i] = sum / kLooks * (rest[i] + (1 - hidden[i]) * lamp[i]);
    }
  }
  screen_.resize(n);
  to_screen({look_colors_[0], look_colors_[1], look_colors_[2]}, screen_);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t pixel = hits[i].pixel;
    light_[pixel] = {look_colors_[0][i], look_colors_[1][i], look_colors_[2][i]};
    view.depth_m.data()[pixel] = hits[i].far;
    view.infrared.data()[pixel] = material.infrared * surface_.facing[i];
    view.color.data()[pixel] = screen_[i];
  }
}

// Pixels on the outline of a part show the share of each side.
void FigureView::smooth_outline(const RoomView& room, TrueView& view) const {
  // A part's light at the pixel is that of the nearest pixel that shows it.
  const auto light_of = [&](int part, std::size_t pixel) -> const Vector3f& {
    const auto& part_of = hits_.part_of;
    if (part < 0) return room.light(pixel);
    for (const std::size_t place : {pixel, pixel - 1, pixel + 1, pixel - hits_.width, pixel + hits_.width}) {
      if (part_of[place] == part) return light_[place];
    }
    return part_of[pixel] < 0 ? room.light(pixel) : light_[pixel];
  };
  for (std::size_t k = 0; k < hits_.outline.size(); ++k) {
    Vector3f light = Vector3f::Zero();
    for (const int part : hits_.looks[k]) light += light_of(part, hits_.outline[k]);
    view.color.data()[hits_.outline[k]] = to_screen(light / kLooks);
  }
}

void FigureView::erase(const RoomView& room, TrueView& view) {
  for (const auto& [first, count] : hits_.runs) {
    std::copy_n(room.still().depth_m.data() + first, count, view.depth_m.data() + first);
    std::copy_n(room.still().infrared.data() + first, count, view.infrared.data() + first);
    std::copy_n(room.color().data() + first, count, view.color.data() + first);
  }
  hits_.clear();
}

void FigureView::draw(const Sight& sight, const RoomView& room, std::span<const Eigen::Isometry3f> pose,
                      std::span<const Capsule> capsules, How how, TrueView& view) {
  const Image<float>& walls = room.still().depth_m;
  if (how == How::kByRays || !raster_.find(sight, walls, pose, hits_)) rays_.find(sight, walls, pose, hits_);
  const std::vector<Mesh>& parts = world_->figure().parts;
  for (std::size_t part = 0; part < parts.size(); ++part)
    find_pattern(parts[part], hits_.parts[part], pattern_);
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const std::span<const Hit> hits(hits_.parts[part]);
    for (std::size_t first = 0; first < hits.size(); first += kTogether)
      draw_some(part, pose[part], hits.subspan(first, std::min(kTogether, hits.size() - first)), sight,
                capsules, view);
  }
  smooth_outline(room, view);
}

}  // namespace copresence::simulation
