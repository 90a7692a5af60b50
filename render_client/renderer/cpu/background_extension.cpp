#include "render_client/renderer/cpu/background_extension.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "render_client/renderer/extension_rules.h"

namespace copresence::renderer {
namespace {

// Directions 2 i and 2 i + 1 are opposite.
constexpr std::array<std::array<int, 2>, 8> kDirections{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
constexpr float kDiagonal = 1.41421356F;
constexpr float kSmallestW = 1 / kFarthestM;
constexpr float kLeastOpacity = 1.0F / 255;

bool is_same_surface(float w, float other) {
  return std::abs(w - other) <= kSameSurface;
}

struct Mean {
  float w = 0, r = 0, g = 0, b = 0, weight = 0;

  template <class Surface>
  void add(const Surface& surface, float share) {
    w += share * surface.w;
    r += share * surface.r;
    g += share * surface.g;
    b += share * surface.b;
    weight += share;
  }
  template <class Surface>
  void store(Surface& surface) const {
    const float scale = 1 / weight;
    surface.w = w * scale;
    surface.r = r * scale;
    surface.g = g * scale;
    surface.b = b * scale;
  }
};

}  // namespace

std::size_t BackgroundExtension::apply(const ViewPose& eye, std::span<const CameraView> cameras,
                                       const InverseDepthView& seen, const UnseenStyle& style,
                                       Executor& workers, MergedView& view) {
  assert(seen.width() == view.width && seen.height() == view.height && view.color.width() == view.width);
  width_ = (view.width + kExtensionBlock - 1) / kExtensionBlock;
  height_ = (view.height + kExtensionBlock - 1) / kExtensionBlock;
  const std::size_t count = static_cast<std::size_t>(width_) * height_;
  list_pictures(eye, cameras);
  blocks_.resize(count);
  estimates_.resize(count);
  smoothed_.resize(count);
  workers.run(height_, [&](int y, int) {
    for (int x = 0; x < width_; ++x) blocks_[index(x, y)] = summarise(seen, view.color, x, y);
  });
  workers.run(static_cast<int>(kDirections.size()), [&](int direction, int) {
    find_sources(kDirections[direction][0], kDirections[direction][1], sources_[direction]);
  });
  workers.run(height_, [&](int y, int) {
    for (int x = 0; x < width_; ++x) estimates_[index(x, y)] = estimate(index(x, y));
  });
  for (int round = 0; round < kSmoothingRounds; ++round) {
    workers.run(height_, [&](int y, int) { smooth_row(y, estimates_, smoothed_); });
    estimates_.swap(smoothed_);
  }
  workers.run(height_, [&](int y, int) {
    for (int x = 0; x < width_; ++x) {
      Block& block = estimates_[index(x, y)];
      if (block.is_gap) block.opacity = block.w > 0 ? opacity_at(eye, x, y, block.w) : 0;
    }
  });
  filled_.assign(height_, 0);
  workers.run(height_, [&](int y, int) {
    for (int row = y * kExtensionBlock; row < std::min((y + 1) * kExtensionBlock, view.height); ++row)
      filled_[y] += fill_row(row, seen, style, view);
  });
  return std::accumulate(filled_.begin(), filled_.end(), std::size_t{0});
}

BackgroundExtension::Block BackgroundExtension::summarise(const InverseDepthView& seen,
                                                          const Image<Rgba8>& color, int block_x,
                                                          int block_y) const {
  const int left = block_x * kExtensionBlock, right = std::min(left + kExtensionBlock, seen.width());
  const int top = block_y * kExtensionBlock, bottom = std::min(top + kExtensionBlock, seen.height());
  constexpr float kNone = 1e9F;
  Block block;
  float farthest = kNone;
  for (int y = top; y < bottom; ++y) {
    const float* const row = seen.row(y).data();
    for (int x = left; x < right; ++x) {
      if (row[x] > 0) {
        farthest = std::min(farthest, row[x]);
      } else {
        block.is_gap = true;
      }
    }
  }
  if (farthest == kNone) return block;
  Mean mean;
  for (int y = top; y < bottom; ++y) {
    const float* const row = seen.row(y).data();
    const Rgba8* const colors = color.row(y).data();
    for (int x = left; x < right; ++x) {
      if (row[x] <= 0 || row[x] > farthest + kOwnSurface) continue;
      const Rgba8 pixel = colors[x];
      mean.add(Block{row[x], float(pixel.r), float(pixel.g), float(pixel.b)}, 1);
    }
  }
  mean.store(block);
  return block;
}

// Finds the source of each block in the direction (-dx, -dy).
void BackgroundExtension::find_sources(int dx, int dy, std::vector<Source>& sources) const {
  sources.resize(blocks_.size());
  const int step_x = dx >= 0 ? 1 : -1, step_y = dy >= 0 ? 1 : -1;
  for (int y = step_y > 0 ? 0 : height_ - 1; y >= 0 && y < height_; y += step_y) {
    for (int x = step_x > 0 ? 0 : width_ - 1; x >= 0 && x < width_; x += step_x) {
      Source source;
      if (!blocks_[index(x, y)].is_gap) {
        source = source_at(x, y, dx, dy);
      } else if (contains(x - dx, y - dy)) {
        source = sources[index(x - dx, y - dy)];
        ++source.distance;
      }
      sources[index(x, y)] = source;
    }
  }
}

// Returns the source for a gap that follows block (x, y) in the direction (dx, dy).
BackgroundExtension::Source BackgroundExtension::source_at(int x, int y, int dx, int dy) const {
  const auto surface = [&](int behind) -> const Block* {
    const int at_x = x - behind * dx, at_y = y - behind * dy;
    if (!contains(at_x, at_y)) return nullptr;
    const Block& block = blocks_[index(at_x, at_y)];
    return block.is_gap ? nullptr : &block;
  };
  const Block& edge = blocks_[index(x, y)];
  Source source{static_cast<std::int32_t>(index(x, y)), 0, 0};
  const Block* const second = surface(1);
  if (second && is_same_surface(second->w, edge.w)) {
    source = {static_cast<std::int32_t>(index(x - dx, y - dy)), 1, 0};
    const Block *const third = surface(2), *const fourth = surface(3);
    if (third && fourth) {
      const float slope = (second->w - fourth->w) / 2;
      const bool is_straight = std::abs(third->w - (second->w + fourth->w) / 2) <= kOwnSurface / 4;
      if (is_straight && std::abs(slope) <= kMostSlope) source.slope = slope;
    }
  }
  return source;
}

BackgroundExtension::Block BackgroundExtension::estimate(std::size_t at) const {
  const Block& own = blocks_[at];
  if (!own.is_gap) return own;
  struct Candidate {
    float w, r, g, b, weight;
  };
  std::array<Candidate, 5> candidates;
  std::size_t count = 0;
  if (own.w > 0) candidates[count++] = {own.w, own.r, own.g, own.b, kOwnWeight};
  for (int pair = 0; pair < 4; ++pair) {
    const Source &one = sources_[2 * pair][at], &other = sources_[2 * pair + 1][at];
    const float length = pair < 2 ? 1 : kDiagonal;
    const auto continued = [&](const Source& source) {
      return blocks_[source.block].w + source.slope * static_cast<float>(source.distance);
    };
    const auto add_alone = [&](const Source& source, float most_w) {
      const Block& from = blocks_[source.block];
      const float w = std::clamp(continued(source), (1 - kMostChange) * from.w, (1 + kMostChange) * from.w);
      candidates[count++] = {std::min(w, most_w), from.r, from.g, from.b,
                             1 / (1 + length * static_cast<float>(source.distance))};
    };
    constexpr float kAny = 1e9F;
    if (one.block < 0 && other.block < 0) continue;
    if (one.block < 0 || other.block < 0) {
      add_alone(one.block < 0 ? other : one, kAny);
      continue;
    }
    const Block &from_one = blocks_[one.block], &from_other = blocks_[other.block];
    if (is_same_surface(continued(one), continued(other))) {
      const float share =
          static_cast<float>(other.distance) / static_cast<float>(one.distance + other.distance);
      const auto between = [share](float a, float b) { return share * a + (1 - share) * b; };
      const auto nearest = static_cast<float>(std::min(one.distance, other.distance));
      candidates[count++] = {between(from_one.w, from_other.w), between(from_one.r, from_other.r),
                             between(from_one.g, from_other.g), between(from_one.b, from_other.b),
                             2 / (1 + length * nearest)};
    } else if (from_one.w < from_other.w) {
      add_alone(one, from_other.w);
    } else {
      add_alone(other, from_one.w);
    }
  }
  Block result;
  result.is_gap = true;
  if (count == 0) return result;
  float farthest = candidates[0].w;
  for (std::size_t i = 1; i < count; ++i) farthest = std::min(farthest, candidates[i].w);
  Mean mean;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_same_surface(candidates[i].w, farthest)) mean.add(candidates[i], candidates[i].weight);
  }
  mean.store(result);
  result.w = std::max(result.w, kSmallestW);
  return result;
}

void BackgroundExtension::smooth_row(int y, const std::vector<Block>& from, std::vector<Block>& to) const {
  for (int x = 0; x < width_; ++x) {
    const Block& own = from[index(x, y)];
    Block& result = to[index(x, y)];
    result = own;
    if (!own.is_gap || own.w == 0) continue;
    Mean mean;
    mean.add(own, 2);
    for (int i = 0; i < 4; ++i) {
      const int beside_x = x + kDirections[i][0], beside_y = y + kDirections[i][1];
      if (!contains(beside_x, beside_y)) continue;
      const Block& beside = from[index(beside_x, beside_y)];
      if (beside.w > 0 && is_same_surface(beside.w, own.w)) mean.add(beside, 1);
    }
    mean.store(result);
  }
}

void BackgroundExtension::list_pictures(const ViewPose& eye, std::span<const CameraView> cameras) {
  pictures_.clear();
  for (const CameraView& camera : cameras) {
    if (!(camera.opacity > 0) || camera.is_remembered) continue;
    const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
    const CameraModel& model = camera.model;
    pictures_.push_back({camera_from_eye.rotation.cast<float>(), camera_from_eye.translation.cast<float>(),
                         float(model.fx), float(model.fy), float(model.cx), float(model.cy),
                         float(model.width - 1), float(model.height - 1),
                         1 / (kFadeShare * float(model.width))});
  }
}

float BackgroundExtension::opacity_at(const ViewPose& eye, int x, int y, float w) const {
  constexpr float kHalf = 0.5F * (kExtensionBlock - 1);
  const CameraModel& lens = eye.intrinsics;
  const Eigen::Vector3f point =
      Eigen::Vector3f((float(x * kExtensionBlock) + kHalf - float(lens.cx)) / float(lens.fx),
                      (float(y * kExtensionBlock) + kHalf - float(lens.cy)) / float(lens.fy), 1) /
      w;
  float opacity = 0;
  for (const Picture& picture : pictures_) {
    const Eigen::Vector3f in_camera = picture.rotation * point + picture.translation;
    if (in_camera.z() < float(eye.near_m)) continue;
    // The lens distortion is ignored, since the picture's border need not be exact.
    const float u = picture.fx * in_camera.x() / in_camera.z() + picture.cx;
    const float v = picture.fy * in_camera.y() / in_camera.z() + picture.cy;
    const float outside = std::max({0.0F, -u, -v, u - picture.right, v - picture.bottom});
    opacity = std::max(opacity, 1 - outside * picture.per_fade);
  }
  return opacity;
}

std::size_t BackgroundExtension::fill_row(int y, const InverseDepthView& seen, const UnseenStyle& style,
                                          MergedView& view) const {
  const bool has_depth = view.depth_m.width() == view.width;
  constexpr float kScale = 1.0F / kExtensionBlock;
  const float block_y = (static_cast<float>(y) + 0.5F) * kScale - 0.5F;
  const int top = std::clamp(static_cast<int>(std::floor(block_y)), 0, std::max(0, height_ - 2));
  const float down = std::clamp(block_y - static_cast<float>(top), 0.0F, 1.0F);
  const int next_y = std::min(top + 1, height_ - 1);
  const Rgb8 background = style.background;
  constexpr float kLeastShare = 1e-4F;
  std::size_t filled = 0;
  // Means over the blocks on the farthest surface, for the left and right column of blocks beside
  // the pixel. They are computed once per `column`.
  int column = -1;
  std::array<Mean, 2> sides;
  std::array<float, 2> opacities{0, 0};
  for (int x = 0; x < view.width; ++x) {
    if (seen(x, y) > 0) continue;
    const float block_x = (static_cast<float>(x) + 0.5F) * kScale - 0.5F;
    const int left = std::clamp(static_cast<int>(std::floor(block_x)), 0, std::max(0, width_ - 2));
    const float right = std::clamp(block_x - static_cast<float>(left), 0.0F, 1.0F);
    if (left != column) {
      column = left;
      const int next_x = std::min(left + 1, width_ - 1);
      const std::array blocks{&estimates_[index(left, top)], &estimates_[index(left, next_y)],
                              &estimates_[index(next_x, top)], &estimates_[index(next_x, next_y)]};
      float farthest = 1e9F;
      for (const Block* const block : blocks) {
        if (block->w > 0) farthest = std::min(farthest, block->w);
      }
      sides = {};
      opacities = {0, 0};
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i]->w == 0 || !is_same_surface(blocks[i]->w, farthest)) continue;
        const float share = i % 2 == 0 ? 1 - down : down;
        sides[i / 2].add(*blocks[i], share + kLeastShare);
        opacities[i / 2] += (share + kLeastShare) * blocks[i]->opacity;
      }
    }
    const float one = 1 - right + kLeastShare, other = right + kLeastShare;
    const auto between = [&](float a, float b) { return one * a + other * b; };
    const float weight = between(sides[0].weight, sides[1].weight);
    const float opacity_sum = between(opacities[0], opacities[1]);
    Rgba8& pixel = view.color(x, y);
    pixel = {background.r, background.g, background.b, 0};
    if (weight == 0 || opacity_sum < kLeastOpacity * weight) continue;
    const float scale = 1 / weight, opacity = opacity_sum * scale,
                surface = opacity * style.brightness() * scale;
    const auto blend = [&](float a, float b, std::uint8_t behind) {
      return static_cast<std::uint8_t>(surface * between(a, b) + (1 - opacity) * behind + 0.5F);
    };
    pixel = {blend(sides[0].r, sides[1].r, background.r), blend(sides[0].g, sides[1].g, background.g),
             blend(sides[0].b, sides[1].b, background.b), 255};
    if (has_depth) {
      view.depth_m(x, y) = weight / between(sides[0].w, sides[1].w);
      view.origin(x, y) = Origin::kExtended;
    }
    ++filled;
  }
  return filled;
}

}  // namespace copresence::renderer
