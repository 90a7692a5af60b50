#include "render_client/renderer/cpu/background_extension.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numeric>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/extension_rules.h"

namespace copresence::renderer {
namespace {

// Directions 2 i and 2 i + 1 are opposite.
constexpr std::array<std::array<int, 2>, 8> kDirections{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
constexpr float kDiagonal = 1.41421356F;
constexpr float kSmallestW = 1 / kFarthestM;
constexpr float kLeastOpacity = 1.0F / 255;

constexpr float kLeastShare = 1e-4F;      // Keeps sums of shares above 0.
constexpr float kAboveAnyInverse = 1e9F;  // Larger than any inverse depth.

static_assert(kExtensionBlock == kLanes, "a row of a block is treated at once");

bool is_same_surface(float w, float other) {
  return std::abs(w - other) <= kSameSurface;
}

}  // namespace

void BackgroundExtension::begin(int width, int height) {
  width_ = (width + kExtensionBlock - 1) / kExtensionBlock;
  height_ = (height + kExtensionBlock - 1) / kExtensionBlock;
  const std::size_t count = static_cast<std::size_t>(width_) * height_;
  blocks_.resize(count);
  is_gap_.resize(count);
  estimates_.resize(count);
  smoothed_.resize(count);
}

void BackgroundExtension::survey(const InverseDepthView& seen, int top, int rows) {
  assert(top % kExtensionBlock == 0);
  for (int y = top / kExtensionBlock; y * kExtensionBlock < top + rows; ++y) {
    for (int x = 0; x < width_; ++x) find_farthest(seen, x, y);
  }
}

std::size_t BackgroundExtension::apply(const ViewPose& eye, std::span<const CameraView> cameras,
                                       std::span<const CameraPictures> pictures, const InverseDepthView& seen,
                                       const UnseenStyle& style, Executor& workers, MergedView& view) {
  assert(seen.width() == view.width && seen.height() == view.height && view.color.width() == view.width);
  list_gaps();
  if (gaps_.empty()) return 0;
  list_pictures(eye, cameras);
  colors_.begin(eye, cameras, pictures);
  // These steps take about a millisecond. Waiting for the workers after each step takes longer on a
  // busy machine.
  const std::vector<std::int32_t> near = near_gaps();
  for (const std::int32_t block : near) average_farthest(seen, view.color, block);
  for (std::size_t i = 0; i < kDirections.size(); ++i)
    find_sources(kDirections[i][0], kDirections[i][1], sources_[i]);
  for (const std::int32_t block : near)
    estimates_[block] = smoothed_[block] = is_gap_[block] ? estimate(block) : blocks_[block];
  for (int round = 0; round < kSmoothingRounds; ++round) {
    for (const std::int32_t block : gaps_) smoothed_[block] = smoothed(block);
    estimates_.swap(smoothed_);
  }
  for (const std::int32_t block : gaps_) find_visibility(eye, block);
  filled_.assign(height_, 0);
  workers.run(height_, [&](int y, int) {
    for (int row = y * kExtensionBlock; row < std::min((y + 1) * kExtensionBlock, view.height); ++row)
      filled_[y] += fill_row(row, seen, style, view);
  });
  return std::accumulate(filled_.begin(), filled_.end(), std::size_t{0});
}

void BackgroundExtension::list_gaps() {
  gaps_.clear();
  for (std::size_t at = 0; at < is_gap_.size(); ++at) {
    if (is_gap_[at]) gaps_.push_back(static_cast<std::int32_t>(at));
  }
}

// Finds out whether the block is a gap, and the smallest inverse depth of its pixels.
void BackgroundExtension::find_farthest(const InverseDepthView& seen, int block_x, int block_y) {
  const int left = block_x * kExtensionBlock, columns = std::min(kExtensionBlock, seen.width() - left);
  const int top = block_y * kExtensionBlock, bottom = std::min(top + kExtensionBlock, seen.height());
  const Ints inside = ramp() < static_cast<float>(columns);
  Floats least = all(kAboveAnyInverse);
  Ints empty{};
  for (int y = top; y < bottom; ++y) {
    const auto w = load_first<Floats>(&seen(left, y), columns);
    const Ints is_seen = w > 0;
    empty |= inside & ~is_seen;
    least = is_seen ? smaller(least, w) : least;
  }
  const std::size_t at = index(block_x, block_y);
  is_gap_[at] = bits(empty) != 0 ? 1 : 0;
  float farthest = kAboveAnyInverse;
  for (int lane = 0; lane < kLanes; ++lane) farthest = std::min(farthest, least[lane]);
  blocks_[at] = Block{.w = farthest < kAboveAnyInverse ? farthest : 0};
}

// Lists the blocks whose surface and colour may be asked for: gaps, and the blocks around them.
std::vector<std::int32_t> BackgroundExtension::near_gaps() const {
  constexpr int kAround = 4;  // A source looks at the three blocks behind the one beside the gap.
  std::vector<std::uint8_t> beside(is_gap_.size()), near(width_);
  for (const std::int32_t at : gaps_) {
    const int x = at % width_, first = std::max(0, x - kAround), last = std::min(width_ - 1, x + kAround);
    std::fill_n(beside.begin() + (at - x + first), last - first + 1, std::uint8_t{1});
  }
  std::vector<std::int32_t> blocks;
  for (int y = 0; y < height_; ++y) {
    std::fill(near.begin(), near.end(), std::uint8_t{0});
    for (int row = std::max(0, y - kAround); row <= std::min(height_ - 1, y + kAround); ++row) {
      for (int x = 0; x < width_; ++x) near[x] |= beside[index(x, row)];
    }
    for (int x = 0; x < width_; ++x) {
      if (near[x]) blocks.push_back(static_cast<std::int32_t>(index(x, y)));
    }
  }
  return blocks;
}

// Replaces the smallest inverse depth of a block by the mean of its farthest surface.
void BackgroundExtension::average_farthest(const InverseDepthView& seen, const Image<Rgba8>& color,
                                           std::int32_t at) {
  Block& block = blocks_[at];
  if (block.w == 0) return;
  const int block_x = at % width_, block_y = at / width_;
  const int left = block_x * kExtensionBlock, columns = std::min(kExtensionBlock, seen.width() - left);
  const int top = block_y * kExtensionBlock, bottom = std::min(top + kExtensionBlock, seen.height());
  const float nearest = block.w + kOwnSurface;
  Floats w_sum{}, r{}, g{}, b{};
  Ints count{};
  for (int y = top; y < bottom; ++y) {
    const auto w = load_first<Floats>(&seen(left, y), columns);
    const auto pixels = load_first<Ints>(&color(left, y), columns);
    const Ints counts = (w > 0) & (w <= nearest);
    count -= counts;
    w_sum += counts ? w : Floats{};
    r += as_floats(counts & pixels & 255);
    g += as_floats(counts & (pixels >> 8) & 255);
    b += as_floats(counts & (pixels >> 16) & 255);
  }
  const float scale = 1 / sum(as_floats(count));
  block.w = sum(w_sum) * scale;
  block.r = sum(r) * scale;
  block.g = sum(g) * scale;
  block.b = sum(b) * scale;
}

// Finds the source of each block in the direction (-dx, -dy).
void BackgroundExtension::find_sources(int dx, int dy, std::vector<Source>& sources) const {
  sources.resize(blocks_.size());
  const int step_x = dx >= 0 ? 1 : -1, step_y = dy >= 0 ? 1 : -1;
  for (int y = step_y > 0 ? 0 : height_ - 1; y >= 0 && y < height_; y += step_y) {
    for (int x = step_x > 0 ? 0 : width_ - 1; x >= 0 && x < width_; x += step_x) {
      Source source;
      if (!is_gap_[index(x, y)]) {
        // Only a gap asks for sources.
        if (!contains(x + dx, y + dy) || !is_gap_[index(x + dx, y + dy)]) continue;
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
    const std::size_t at = index(at_x, at_y);
    return is_gap_[at] ? nullptr : &blocks_[at];
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
    if (one.block < 0 && other.block < 0) continue;
    if (one.block < 0 || other.block < 0) {
      add_alone(one.block < 0 ? other : one, kAboveAnyInverse);
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

// Returns the estimate of a gap, averaged with its neighbours on the same surface.
BackgroundExtension::Block BackgroundExtension::smoothed(std::int32_t at) const {
  const int x = at % width_, y = at / width_;
  const Block& own = estimates_[at];
  if (own.w == 0) return own;
  Mean mean;
  mean.add(own, 2);
  for (int i = 0; i < 4; ++i) {
    const int beside_x = x + kDirections[i][0], beside_y = y + kDirections[i][1];
    if (!contains(beside_x, beside_y)) continue;
    const Block& beside = estimates_[index(beside_x, beside_y)];
    if (beside.w > 0 && is_same_surface(beside.w, own.w)) mean.add(beside, 1);
  }
  Block result;
  mean.store(result);
  return result;
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

void BackgroundExtension::find_visibility(const ViewPose& eye, std::int32_t at) {
  Block& block = estimates_[at];
  if (block.w == 0) {
    block.opacity = 0;
    return;
  }
  const int x = at % width_, y = at / width_;
  block.opacity = opacity_at(eye, x, y, block.w);
  block.may_be_pictured =
      colors_.may_show(x * kExtensionBlock, y * kExtensionBlock, kExtensionBlock, block.w);
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
  const float block_y = (static_cast<float>(y) + 0.5F) / kExtensionBlock - 0.5F;
  const int top = std::clamp(static_cast<int>(std::floor(block_y)), 0, std::max(0, height_ - 2));
  const float down = std::clamp(block_y - static_cast<float>(top), 0.0F, 1.0F);
  std::size_t filled = 0;
  // Fills eight pixels at a time, from the middle of a block to the middle of the next block.
  for (int left = -1; left < width_; ++left) {
    const std::size_t block = index(std::max(left, 0), y / kExtensionBlock);
    const std::size_t next = index(std::min(left + 1, width_ - 1), y / kExtensionBlock);
    if (!is_gap_[block] && !is_gap_[next]) continue;
    const int x = left * kExtensionBlock + kExtensionBlock / 2;
    const int first = std::max(x, 0), columns = std::min(x + kLanes, view.width) - first;
    if (columns <= 0) continue;
    const auto w = load_first<Floats>(&seen(first, y), columns);
    const Ints empty = (w <= 0) & (ramp() < static_cast<float>(columns));
    if (bits(empty) == 0) continue;
    const int pair = std::clamp(left, 0, std::max(0, width_ - 2));
    const float before =
        (static_cast<float>(first) + 0.5F) / kExtensionBlock - 0.5F - static_cast<float>(pair);
    const Floats right = smaller(larger(all(before) + ramp() / kExtensionBlock, Floats{}), all(1.0F));
    const bool may_be_pictured = estimates_[block].may_be_pictured || estimates_[next].may_be_pictured;
    filled += fill_pixels(first, y, columns, empty, right, surfaces_between(pair, top, down), may_be_pictured,
                          style, view);
  }
  return filled;
}

// Returns the four blocks around a pixel, mixed vertically. Only blocks on the farthest of their
// surfaces count.
BackgroundExtension::Surfaces BackgroundExtension::surfaces_between(int left, int top, float down) const {
  const int next_x = std::min(left + 1, width_ - 1), next_y = std::min(top + 1, height_ - 1);
  const std::array blocks{&estimates_[index(left, top)], &estimates_[index(left, next_y)],
                          &estimates_[index(next_x, top)], &estimates_[index(next_x, next_y)]};
  float farthest = kAboveAnyInverse;
  for (const Block* const block : blocks) {
    if (block->w > 0) farthest = std::min(farthest, block->w);
  }
  Surfaces surfaces;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i]->w == 0 || !is_same_surface(blocks[i]->w, farthest)) continue;
    const float share = (i % 2 == 0 ? 1 - down : down) + kLeastShare;
    surfaces.sides[i / 2].add(*blocks[i], share);
    surfaces.opacities[i / 2] += share * blocks[i]->opacity;
  }
  return surfaces;
}

// Fills the `empty` ones of the pixels from (x, y) on. `right` is the share of the right surface.
// Returns the number of pixels filled.
std::size_t BackgroundExtension::fill_pixels(int x, int y, int columns, const Ints& empty,
                                             const Floats& right, const Surfaces& surfaces,
                                             bool may_be_pictured, const UnseenStyle& style,
                                             MergedView& view) const {
  const Floats one = 1 - right + kLeastShare, other = right + kLeastShare;
  const auto between = [&](float a, float b) { return one * a + other * b; };
  const auto& [left_side, right_side] = surfaces.sides;
  const Floats weight = between(left_side.weight, right_side.weight);
  const Floats opacity_sum = between(surfaces.opacities[0], surfaces.opacities[1]);
  const Ints fills = empty & (weight > 0) & (opacity_sum >= kLeastOpacity * weight);
  const Floats scale = 1 / larger(weight, all(kLeastShare));
  const Floats opacity = opacity_sum * scale, brightness = opacity * style.brightness() * scale;
  const auto blend = [&](float a, float b, std::uint8_t behind) {
    return truncated(brightness * between(a, b) + (1 - opacity) * static_cast<float>(behind) + 0.5F);
  };
  const Rgb8 back = style.background;
  const auto packed = [](const Ints& r, const Ints& g, const Ints& b) {
    return r | g << 8 | b << 16 | static_cast<std::int32_t>(0xFF000000U);
  };
  Ints surface = packed(blend(left_side.r, right_side.r, back.r), blend(left_side.g, right_side.g, back.g),
                        blend(left_side.b, right_side.b, back.b));
  const Floats w = larger(between(left_side.w, right_side.w) * scale, all(kSmallestW));
  if (may_be_pictured) {
    const PictureColors::Colors seen = colors_.find(x, y, w, fills);
    const auto dimmed = [&](const Floats& value) { return truncated(style.brightness() * value + 0.5F); };
    surface = seen.found ? packed(dimmed(seen.r), dimmed(seen.g), dimmed(seen.b)) : surface;
  }
  const Ints background = all(back.r | back.g << 8 | back.b << 16);
  const auto shown = load_first<Ints>(&view.color(x, y), columns);
  store_first(&view.color(x, y), fills ? surface : empty ? background : shown, columns);
  if (view.depth_m.width() == view.width) {
    for (unsigned lanes = bits(fills); lanes != 0; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      view.depth_m(x + lane, y) = 1 / w[lane];
      view.origin(x + lane, y) = Origin::kExtended;
    }
  }
  return static_cast<std::size_t>(std::popcount(bits(fills)));
}

}  // namespace copresence::renderer
