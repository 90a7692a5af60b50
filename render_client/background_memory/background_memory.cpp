#include "render_client/background_memory/background_memory.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <utility>

namespace copresence::background_memory {
namespace {

constexpr double kToleranceSteps = 4;  // Greatest difference within one surface, in disparity steps.
constexpr int kBlock = 8;              // Width and height of a block, in pixels.
constexpr int kFewestCovered = 3;      // A covered block has at least this many covered pixels.
constexpr int kFewestRefuted = 8;      // A refuted block has at least this many refuted pixels.
constexpr int kMeanShift = 2;          // A new value changes a mean by 1 / 2^2 of the difference.
constexpr int kColorEvery = 6;         // Each row's colours are compared in one of this many frames.

// Blocks around covered ones are drawn, too. So the drawn surface meets the surface that is seen.
// Also, a covering object may move a little before the surface behind it must be drawn again.
constexpr int kDrawnAround = 2, kNeededAround = 1;
constexpr std::uint64_t kRedrawEvery = 60;  // In frames.

// A camera has moved if most regions of its picture differ from the remembered surfaces. The
// following limits define when they differ. A still camera sees something new only where objects
// move.
constexpr int kRegionsAcross = 8, kRegionsDown = 6;
constexpr std::uint32_t kFewestInRegion = 100;
constexpr double kMostFarther = 0.04;     // Share of a region's known pixels.
constexpr double kLeastAgreement = 0.35;  // Limit for Comparison::agree, as a share of `known`.
constexpr double kMostRecolored = 0.25;   // Limit for Comparison::recolored, as a share of `colored`.
constexpr int kSameColor = 40;            // Limit for the sum of the differences of red, green and blue.

// After a motion of the camera, learning pauses. Then surfaces are learned again, and they are drawn
// if the camera has not moved meanwhile. So a hand-held camera costs little and shows nothing false.
constexpr std::uint64_t kPauseFrames = 30;  // At 30 frames per second, one second.
constexpr std::uint64_t kWatchFrames = 2 * kSteadyFrames;

// Says what a pixel shows, compared with the remembered surface. At most one flag is set.
enum Flag : std::uint8_t { kCovered = 1, kAgrees = 2, kFarther = 4 };

enum ColorQuality : std::uint8_t {
  kNoColor,
  kNearSilhouette,  // The colour may belong to an object beside the surface.
  kGoodColor,
};

// Sets all blocks within `radius` blocks of a block that is set.
void widen(const Image<std::uint8_t>& blocks, int radius, Image<std::uint8_t>& wide) {
  const int width = blocks.width(), height = blocks.height();
  wide.resize(width, height);
  std::fill(wide.pixels().begin(), wide.pixels().end(), std::uint8_t{0});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (blocks(x, y) == 0) continue;
      const int left = std::max(0, x - radius), right = std::min(width - 1, x + radius);
      for (int row = std::max(0, y - radius); row <= std::min(height - 1, y + radius); ++row)
        std::fill(&wide(left, row), &wide(right, row) + 1, std::uint8_t{1});
    }
  }
}

int mean_of(int mean, int value) {
  constexpr int kHalf = 1 << (kMeanShift - 1);
  return mean + ((value - mean + kHalf) >> kMeanShift);
}

int difference(const Rgb8& a, const Rgb8& b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
}

}  // namespace

BackgroundMemory::Tolerance::Tolerance(double per_square)
    : per_square_(std::max(1, static_cast<int>(per_square * (1 << (2 * kCoarse + kFraction)) + 0.5))),
      most_(static_cast<int>(std::sqrt(std::numeric_limits<int>::max() / per_square_)) - 1) {}

void BackgroundMemory::begin(DepthUnit unit, const DepthNoise& noise) {
  unit_ = unit;
  tolerance_ = Tolerance(kToleranceSteps * noise.inverse_step() * metres_per_unit(unit));
  depth_ = {};
  has_color_ = false;
  frames_ = resumes_at_ = 0;
  covered_.reset();
}

void BackgroundMemory::forget(int width, int height) {
  const int across = (width + kBlock - 1) / kBlock, down = (height + kBlock - 1) / kBlock;
  depth_ = candidate_ = DepthImage(width, height);
  color_ = ColorImage(width, height);
  times_seen_ = Image<std::uint16_t>(width, height);
  color_quality_ = Image<std::uint8_t>(width, height);
  covered_pixels_ = refuted_pixels_ = near_covered_ = drawn_ = Image<std::uint8_t>(across, down);
  flags_.assign(static_cast<std::size_t>(across) * kBlock, 0);
  covered_.reset();
}

void BackgroundMemory::learn(const RgbdFrame& frame) {
  const int width = frame.depth.width(), height = frame.depth.height();
  assert(frame.state.width() == width && frame.state.height() == height);
  assert(!frame.color || (frame.color->width() == width && frame.color->height() == height));
  const Rigid3& pose = frame.metadata.world_from_camera;
  if (width != depth_.width() || height != depth_.height() || !(pose == pose_)) forget(width, height);
  pose_ = pose;
  has_color_ = has_color_ || frame.color;
  ++frames_;
  if (frames_ < resumes_at_) return;
  for (auto* blocks : {&covered_pixels_, &refuted_pixels_})
    std::fill(blocks->pixels().begin(), blocks->pixels().end(), std::uint8_t{0});
  std::array<Comparison, kRegionsAcross * kRegionsDown> regions{};
  for (int y = 0; y < height; ++y) {
    learn_depth(frame, y);
    count_flags(y, &regions[static_cast<std::size_t>(y * kRegionsDown / height) * kRegionsAcross]);
  }
  for (std::uint8_t& pixels : covered_pixels_.pixels()) pixels = pixels >= kFewestCovered;
  for (std::uint8_t& pixels : refuted_pixels_.pixels()) pixels = pixels >= kFewestRefuted;
  widen(covered_pixels_, kNeededAround, near_covered_);
  Comparison colors;
  if (frame.color) {
    for (int y = int(frames_ % kColorEvery); y < height; y += kColorEvery) learn_colors(frame, y, colors);
  }
  if (camera_has_moved(regions, colors)) {
    forget(width, height);
    resumes_at_ = frames_ + kPauseFrames;
    return;
  }
  if (frames_ >= resumes_at_ + kWatchFrames) draw_covered(frame);
}

// Compares the depths in row y with the remembered ones, and remembers farther surfaces.
void BackgroundMemory::learn_depth(const RgbdFrame& frame, int y) {
  const std::uint16_t* const measured = frame.depth.row(y).data();
  const DepthState* const states = frame.state.row(y).data();
  std::uint16_t* const remembered = depth_.row(y).data();
  std::uint16_t* const candidates = candidate_.row(y).data();
  std::uint16_t* const times_seen = times_seen_.row(y).data();
  std::uint8_t* const qualities = color_quality_.row(y).data();
  std::uint8_t* const flags = flags_.data();
  const Tolerance tolerance_of = tolerance_;
  const int width = depth_.width();
  // The loop has no branches, so that the compiler can vectorise it.
#pragma GCC ivdep
  for (int x = 0; x < width; ++x) {
    const int z = measured[x], before = remembered[x], candidate = candidates[x], seen = times_seen[x];
    const int quality = qualities[x], state = static_cast<int>(states[x]);
    const int tolerance = tolerance_of(std::max(z, before));
    const int is_known = before > 0;
    const int is_measured = (z > 0) & (state == static_cast<int>(DepthState::kMeasured));
    const int is_farther = (z - before > tolerance) & is_measured;
    const int is_covered = (before - z > tolerance) & is_known;
    const int agrees = is_known & is_measured & (is_farther ^ 1) & (is_covered ^ 1);
    const int is_steady = (std::abs(z - candidate) <= tolerance) & is_farther;
    const int new_candidate = is_steady ? mean_of(candidate, z) : z;
    const int count = is_steady ? seen + 1 : is_farther;
    const int new_seen = is_farther | agrees ? count : seen;
    const int is_new = new_seen >= kSteadyFrames;
    const int mean = agrees ? mean_of(before, z) : before;
    candidates[x] = static_cast<std::uint16_t>(is_farther ? new_candidate : candidate);
    times_seen[x] = static_cast<std::uint16_t>(is_new ? 0 : new_seen);
    remembered[x] = static_cast<std::uint16_t>(is_new ? new_candidate : mean);
    qualities[x] = static_cast<std::uint8_t>(is_new ? int{kNoColor} : quality);
    flags[x] = static_cast<std::uint8_t>(is_covered * kCovered | agrees * kAgrees |
                                         (is_known & is_farther) * kFarther);
  }
}

// Counts the flags of a row of pixels.
void BackgroundMemory::count_flags(int y, Comparison* regions) {
  std::uint8_t* const covered = covered_pixels_.row(y / kBlock).data();
  std::uint8_t* const refuted = refuted_pixels_.row(y / kBlock).data();
  const int blocks = covered_pixels_.width();
  for (int block = 0; block < blocks; ++block) {
    static_assert(kBlock == sizeof(std::uint64_t));
    std::uint64_t flags = 0;
    std::memcpy(&flags, flags_.data() + static_cast<std::ptrdiff_t>(block) * kBlock, kBlock);
    const auto count = [flags](Flag flag) {
      return static_cast<std::uint32_t>(std::popcount(flags & 0x0101010101010101U * flag));
    };
    Comparison& region = regions[block * kRegionsAcross / blocks];
    const std::uint32_t is_covered = count(kCovered), agree = count(kAgrees), farther = count(kFarther);
    covered[block] = static_cast<std::uint8_t>(covered[block] + is_covered);
    refuted[block] = static_cast<std::uint8_t>(refuted[block] + farther);
    region.known += is_covered + agree + farther;
    region.agree += agree;
    region.farther += farther;
  }
}

// Compares and remembers the colours in row y, where the frame shows the remembered surface.
void BackgroundMemory::learn_colors(const RgbdFrame& frame, int y, Comparison& all) {
  const auto measured = frame.depth.row(y), remembered = std::span<const std::uint16_t>(depth_.row(y));
  const auto states = frame.state.row(y);
  const auto colors = frame.color->row(y);
  const auto kept = color_.row(y);
  const auto qualities = color_quality_.row(y);
  for (int x = 0; x < depth_.width(); ++x) {
    const int z = measured[x], before = remembered[x];
    if (z == 0 || before == 0 || states[x] != DepthState::kMeasured ||
        std::abs(z - before) > tolerance_(std::max(z, before))) {
      continue;
    }
    const Rgb8 color = colors[x];
    if (near_covered_(x / kBlock, y / kBlock)) {
      if (qualities[x] == kGoodColor) continue;
      kept[x] = color;
      qualities[x] = kNearSilhouette;
    } else if (qualities[x] != kGoodColor) {
      kept[x] = color;
      qualities[x] = kGoodColor;
    } else {
      ++all.colored;
      all.recolored += difference(color, kept[x]) > kSameColor;
      const auto follow = [](std::uint8_t& mean, std::uint8_t value) {
        mean = static_cast<std::uint8_t>(mean_of(mean, value));
      };
      follow(kept[x].r, color.r);
      follow(kept[x].g, color.g);
      follow(kept[x].b, color.b);
    }
  }
}

bool BackgroundMemory::camera_has_moved(std::span<const Comparison> regions, const Comparison& colors) {
  if (colors.colored > kFewestInRegion && colors.recolored > kMostRecolored * colors.colored) return true;
  int known = 0, farther = 0, disagreeing = 0;
  for (const Comparison& region : regions) {
    if (region.known < kFewestInRegion) continue;
    ++known;
    farther += region.farther > kMostFarther * region.known;
    disagreeing += region.agree < kLeastAgreement * region.known;
  }
  return 2 * farther > known || 2 * disagreeing > known;
}

void BackgroundMemory::draw_covered(const RgbdFrame& newest) {
  const auto blocks = covered_pixels_.pixels(), needed = near_covered_.pixels(), drawn = drawn_.pixels();
  if (std::none_of(blocks.begin(), blocks.end(), [](std::uint8_t block) { return block != 0; })) {
    std::fill(drawn.begin(), drawn.end(), std::uint8_t{0});
    covered_.reset();
    return;
  }
  const auto refuted = refuted_pixels_.pixels();
  bool is_enough = true;
  for (std::size_t i = 0; i < drawn.size(); ++i) is_enough &= drawn[i] ? !refuted[i] : !needed[i];
  if (is_enough && frames_ - drawn_at_ < kRedrawEvery) return;
  drawn_at_ = frames_;
  widen(covered_pixels_, kDrawnAround, drawn_);
  const int width = depth_.width(), height = depth_.height();
  auto frame = std::make_shared<RgbdFrame>();
  frame->depth = DepthImage(width, height);
  frame->state = StateImage(width, height, DepthState::kHole);
  // Pixels beside the drawn ones have plausible colours, because a renderer interpolates.
  if (has_color_) frame->color = newest.color.value_or(color_);
  for (int y = 0; y < height; ++y) {
    const std::span<const std::uint8_t> is_drawn = drawn_.row(y / kBlock);
    for (int block = 0; block < drawn_.width(); ++block) {
      if (is_drawn[block] == 0) continue;
      for (int x = block * kBlock; x < std::min((block + 1) * kBlock, width); ++x) {
        const bool has_color = color_quality_(x, y) != kNoColor;
        if (has_color_ && has_color) (*frame->color)(x, y) = color_(x, y);
        // A pixel that now shows something farther refutes the remembered surface.
        if (depth_(x, y) == 0 || times_seen_(x, y) > 0 || (has_color_ && !has_color)) continue;
        frame->depth(x, y) = depth_(x, y);
        frame->state(x, y) = DepthState::kMeasured;
      }
    }
  }
  covered_ = std::move(frame);
}

}  // namespace copresence::background_memory
