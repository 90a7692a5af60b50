#include "capture_server/hole_filling/cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "capture_server/hole_filling/filling_rules.h"

static_assert(copresence::hole_filling::Cells::kMarginPx >= 4, "rows end within eight lanes");

namespace copresence::hole_filling {
namespace {

constexpr float kNoSurface = -1e6f;  // A value that differs from every depth by more than any slope allows.
constexpr float kNothingYet = 1e6f;
// In cells. Adding kReachCells to this number does not overflow a byte.
constexpr std::uint8_t kNowhereNear = 200;

// One vector register holds eight pixels.
constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
constexpr Lanes kNowhere{};

void load(const float* from, Lanes& lanes) {
  std::memcpy(&lanes, from, sizeof(lanes));
}
void store(const Lanes& lanes, float* to) {
  std::memcpy(to, &lanes, sizeof(lanes));
}

}  // namespace

Cells::Cells(int width_px, int height_px)
    : columns_((width_px + kCellPx - 1) / kCellPx),
      rows_((height_px + kCellPx - 1) / kCellPx),
      stride_(columns_ + 2 * kMargin),
      pixel_stride_(columns_ * kCellPx + 2 * kMarginPx),
      steps_(static_cast<std::size_t>(pixel_stride_) * (rows_ * kCellPx + 2 * kMarginPx)) {
  const std::size_t cells = static_cast<std::size_t>(stride_) * (rows_ + 2 * kMargin);
  for (auto* plane : {&far, &near, &slope_x, &slope_y, &middle_x_, &middle_y_}) plane->assign(cells, 0);
  for (auto* plane : {&far_count, &near_count, &wanted, &has_depth_}) plane->assign(cells, 0);
  for (auto& direction : reach) direction.assign(cells, 0);
  smooth_.assign(cells, kNoSurface);
  for (auto& line : lines_) line.assign(static_cast<std::size_t>(columns_) + 2 * kLineMargin, kNowhereNear);
  for (auto* line : {&cells_.sum, &cells_.spread}) line->assign(static_cast<std::size_t>(columns_), 0);
  for (auto* line : {&cells_.column_sum, &cells_.row_sum})
    line->assign(static_cast<std::size_t>(columns_), 0);
  const std::size_t padded_width = static_cast<std::size_t>(columns_) * kCellPx + kLanes;
  for (auto* line : {&strip_.sum, &strip_.nearest, &strip_.farthest}) line->assign(padded_width, 0);
  for (auto* line : {&strip_.count, &strip_.row_sum, &strip_.wanted}) line->assign(padded_width, 0);
}

void Cells::see(const DepthImage& depth, const Image<std::uint8_t>& fillable, float steps_times_units) {
  for (int row = 0; row < rows_; ++row) {
    std::fill(strip_.sum.begin(), strip_.sum.end(), 0.0f);
    std::fill(strip_.nearest.begin(), strip_.nearest.end(), 0.0f);
    std::fill(strip_.farthest.begin(), strip_.farthest.end(), kNothingYet);
    std::fill(strip_.count.begin(), strip_.count.end(), std::uint8_t{0});
    std::fill(strip_.row_sum.begin(), strip_.row_sum.end(), std::uint8_t{0});
    std::fill(strip_.wanted.begin(), strip_.wanted.end(), std::uint8_t{0});
    const int end = std::min(depth.height(), (row + 1) * kCellPx);
    for (int y = row * kCellPx; y < end; ++y) add_row(depth.row(y), fillable.row(y), y, steps_times_units);
    close_strip(row);
  }
  find_slopes();
  move_to_middles();
  find_reach();
}

void Cells::add_row(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> fillable, int y,
                    float steps_times_units) {
  const int width = static_cast<int>(depth.size());
  const std::uint16_t* __restrict in = depth.data();
  float* __restrict out = &steps_[pixel_at(0, y)];
  for (int x = 0; x < width; ++x) out[x] = static_cast<float>(in[x]);
  // The last vector may reach into the margin, which is always 0.
  for (int x = 0; x < width; x += kLanes) {
    Lanes units, sum, nearest, farthest;
    load(out + x, units);
    load(&strip_.sum[x], sum);
    load(&strip_.nearest[x], nearest);
    load(&strip_.farthest[x], farthest);
    const auto has = units > 0.0f;
    const Lanes quotient = steps_times_units / (has ? units : kNowhere + 1.0f);
    const Lanes s = has ? quotient : kNowhere;
    const Lanes candidate = has ? quotient : kNowhere + kNothingYet;
    store(s, out + x);
    store(sum + s, &strip_.sum[x]);
    store(nearest > s ? nearest : s, &strip_.nearest[x]);
    store(farthest < candidate ? farthest : candidate, &strip_.farthest[x]);
  }
  const std::uint8_t* __restrict want = fillable.data();
  std::uint8_t* __restrict count = strip_.count.data();
  std::uint8_t* __restrict row_sum = strip_.row_sum.data();
  std::uint8_t* __restrict wants = strip_.wanted.data();
  const auto row = static_cast<std::uint8_t>(y % kCellPx);
  for (int x = 0; x < width; ++x) {
    count[x] = static_cast<std::uint8_t>(count[x] + (in[x] != 0));
    row_sum[x] = static_cast<std::uint8_t>(row_sum[x] + (in[x] != 0 ? row : std::uint8_t{0}));
    wants[x] = static_cast<std::uint8_t>(wants[x] | want[x]);
  }
}

// Adds up the sixteen pixels of each cell. One loop per sum lets compilers vectorise over cells.
void Cells::add_up_cells(std::size_t first) {
  static_assert(kCellPx == 4);
  const auto columns = static_cast<std::size_t>(columns_);
  {
    const float* __restrict const from = strip_.sum.data();
    float* __restrict const to = cells_.sum.data();
    for (std::size_t i = 0; i < columns; ++i)
      to[i] = from[4 * i] + from[4 * i + 1] + from[4 * i + 2] + from[4 * i + 3];
  }
  {
    const float* __restrict const near_px = strip_.nearest.data();
    const float* __restrict const far_px = strip_.farthest.data();
    float* __restrict const spread = cells_.spread.data();
    for (std::size_t i = 0; i < columns; ++i) {
      const float nearest = std::max(std::max(near_px[4 * i], near_px[4 * i + 1]),
                                     std::max(near_px[4 * i + 2], near_px[4 * i + 3]));
      const float farthest = std::min(std::min(far_px[4 * i], far_px[4 * i + 1]),
                                      std::min(far_px[4 * i + 2], far_px[4 * i + 3]));
      spread[i] = nearest - farthest;  // The spread is far below 0 if the cell has no depth.
    }
  }
  {
    const std::uint8_t* __restrict const from = strip_.count.data();
    std::uint8_t* __restrict const counts = &far_count[first];
    std::uint8_t* __restrict const column_sum = cells_.column_sum.data();
    for (std::size_t i = 0; i < columns; ++i) {
      const std::uint8_t a = from[4 * i], b = from[4 * i + 1], c = from[4 * i + 2], d = from[4 * i + 3];
      counts[i] = static_cast<std::uint8_t>(a + b + c + d);
      column_sum[i] = static_cast<std::uint8_t>(b + 2 * c + 3 * d);
    }
  }
  {
    const std::uint8_t* __restrict const from = strip_.row_sum.data();
    const std::uint8_t* __restrict const wants = strip_.wanted.data();
    std::uint8_t* __restrict const row_sum = cells_.row_sum.data();
    std::uint8_t* __restrict const is_wanted = &wanted[first];
    for (std::size_t i = 0; i < columns; ++i) {
      row_sum[i] =
          static_cast<std::uint8_t>(from[4 * i] + from[4 * i + 1] + from[4 * i + 2] + from[4 * i + 3]);
      is_wanted[i] = wants[4 * i] | wants[4 * i + 1] | wants[4 * i + 2] | wants[4 * i + 3];
    }
  }
}

void Cells::close_strip(int row) {
  const auto first = static_cast<std::size_t>(at(0, row)), columns = static_cast<std::size_t>(columns_);
  add_up_cells(first);
  const std::uint8_t* __restrict const counts = &far_count[first];
  std::uint8_t* __restrict const has = &has_depth_[first];
  for (std::size_t i = 0; i < columns; ++i) has[i] = counts[i] >= kCellEnough;
  const float* __restrict const sum = cells_.sum.data();
  const float* __restrict const spread = cells_.spread.data();
  const std::uint8_t* __restrict const column_sum = cells_.column_sum.data();
  const std::uint8_t* __restrict const row_sum = cells_.row_sum.data();
  float* __restrict const mean = &far[first];
  float* __restrict const x = &middle_x_[first];
  float* __restrict const y = &middle_y_[first];
  float* __restrict const smooth = &smooth_[first];
  for (std::size_t i = 0; i < columns; ++i) {
    const float count = counts[i], share = 1 / std::max(count, 1.0f);
    mean[i] = sum[i] * share;
    x[i] = column_sum[i] * share - 0.5f * (kCellPx - 1);
    y[i] = row_sum[i] * share - 0.5f * (kCellPx - 1);
    const float one_surface = spread[i] <= kOneSurface ? mean[i] : kNoSurface;
    smooth[i] = count >= kCellEnough ? one_surface : kNoSurface;
  }
  std::fill_n(&near_count[first], columns, std::uint8_t{0});
  for (int column = 0; column < columns_; ++column) {
    if (cells_.spread[static_cast<std::size_t>(column)] > kOneSurface) split(at(column, row), column, row);
  }
}

void Cells::split(int cell, int column, int row) {
  const float* corner = steps(column * kCellPx, row * kCellPx);
  float nearest = 0, farthest = kNothingYet;
  for (int i = 0; i < kCellPx * kCellPx; ++i) {
    const float s = corner[i / kCellPx * pixel_stride_ + i % kCellPx];
    nearest = std::max(nearest, s);
    farthest = std::min(farthest, s > 0 ? s : kNothingYet);
  }
  const float middle = 0.5f * (nearest + farthest);
  float far_sum = 0, near_sum = 0;
  int far_pixels = 0, near_pixels = 0;
  for (int i = 0; i < kCellPx * kCellPx; ++i) {
    const float s = corner[i / kCellPx * pixel_stride_ + i % kCellPx];
    near_sum += s > middle ? s : 0;
    near_pixels += s > middle;
    far_sum += s > middle ? 0 : s;
    far_pixels += s > 0 && s <= middle;
  }
  far[cell] = far_sum / static_cast<float>(far_pixels);
  near[cell] = near_sum / static_cast<float>(near_pixels);
  far_count[cell] = static_cast<std::uint8_t>(far_pixels);
  near_count[cell] = static_cast<std::uint8_t>(near_pixels);
}

/// Computes slopes from the neighbouring cells on both sides, if these lie on the same surface.
void Cells::find_slopes() {
  constexpr int kApart = 2;
  constexpr float kMostApart = kSteepest * kApart * kCellPx;
  for (int row = 0; row < rows_; ++row) {
    const int first = at(0, row);
    const float* here = &smooth_[first];
    const auto slope = [&](int neighbour, const float* middle, float* out) {
      const float *before = here - neighbour, *after = here + neighbour;
      for (int i = 0; i < columns_; ++i) {
        const float forward = after[i] - here[i], backward = here[i] - before[i];
        const float has_forward = std::abs(forward) <= kMostApart ? 1.0f : 0.0f;
        const float has_backward = std::abs(backward) <= kMostApart ? 1.0f : 0.0f;
        const float rise = has_forward * forward + has_backward * backward;
        const float run = has_forward * (kApart * kCellPx + middle[i + neighbour] - middle[i]) +
                          has_backward * (kApart * kCellPx + middle[i] - middle[i - neighbour]);
        out[i] = here[i] > 0 && run > 0 ? rise / run : 0.0f;
      }
    };
    slope(kApart, &middle_x_[first], &slope_x[first]);
    slope(kApart * stride_, &middle_y_[first], &slope_y[first]);
  }
}

/// Converts each cell's depth from the mean of its pixels to the depth at the cell's middle.
void Cells::move_to_middles() {
  for (int row = 0; row < rows_; ++row) {
    const int first = at(0, row);
    for (int cell = first; cell < first + columns_; ++cell) {
      far[cell] -= slope_x[cell] * middle_x_[cell] + slope_y[cell] * middle_y_[cell];
    }
  }
}

void Cells::find_reach() {
  // A local copy, since compilers must assume that stores through uint8_t change members.
  const int columns = columns_;
  for (std::size_t d = 0; d < kDirections.size(); ++d) {
    const int towards = offset(kDirections[d]);
    // The order of the rows, in which a neighbour's distance is known before it is needed.
    const bool upward = towards > 0;
    std::uint8_t* reaches = reach[d].data();
    for (int i = 0; i < rows_; ++i) {
      const int first = at(0, upward ? rows_ - 1 - i : i);
      const std::uint8_t* has = has_depth_.data() + first + towards;
      if (kDirections[d].dy == 0) {
        find_reach_along(has, kDirections[d].dx, reaches + first);
        continue;
      }
      const std::uint8_t* __restrict next = reaches + first + towards;
      std::uint8_t* __restrict out = reaches + first;
      constexpr std::uint8_t kNothing = 0, kOne = 1;
      for (int x = 0; x < columns; ++x) {
        const std::uint8_t farther =
            next[x] < kReachCells ? static_cast<std::uint8_t>(next[x] + 1) : kNothing;
        const std::uint8_t reached = next[x] != 0 ? farther : kNothing;
        out[x] = has[x] != 0 ? kOne : reached;
      }
    }
  }
}

// Finds the nearest cell with depth among the next 1, 2, 4, 8 and 12 cells, for the whole row at
// once. A simple loop would have to finish each cell before the next.
void Cells::find_reach_along(const std::uint8_t* has, int dx, std::uint8_t* out) {
  static_assert(kReachCells == 12 && kLineMargin >= 4);
  const auto columns = static_cast<std::size_t>(columns_);
  std::uint8_t *from = lines_[0].data() + kLineMargin, *to = lines_[1].data() + kLineMargin;
  for (std::size_t x = 0; x < columns; ++x) from[x] = has[x] != 0 ? std::uint8_t{1} : kNowhereNear;
  for (const int step : {1, 2, 4, 4}) {
    const std::uint8_t* __restrict const here = from;
    const std::uint8_t* __restrict const there = from + dx * step;  // The margins are empty.
    std::uint8_t* __restrict const nearest = to;
    for (std::size_t x = 0; x < columns; ++x)
      nearest[x] = std::min(here[x], static_cast<std::uint8_t>(there[x] + step));
    std::swap(from, to);
  }
  for (std::size_t x = 0; x < columns; ++x) out[x] = from[x] <= kReachCells ? from[x] : std::uint8_t{0};
}

}  // namespace copresence::hole_filling
