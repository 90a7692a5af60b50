#pragma once

// Pairs depth and colour pictures of one instant by their timestamps.
//
// A depth picture is paired as soon as a colour picture within half a period of it has arrived.
// Both streams are in order, so no later picture can be nearer. A depth picture without colour is
// released when a later colour picture has arrived, or when the caller stops waiting.
//
// Thread: one thread at a time per object.

#include <cstdint>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>

#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

/// `Picture` must be movable and cheap to copy, such as a reference-counted pointer.
template <class Picture>
class FrameSynchronizer {
 public:
  struct Pair {
    std::int64_t timestamp_us = 0;  ///< Timestamp of the depth picture.
    Picture depth;
    std::optional<Picture> color;
    std::int64_t color_timestamp_us = 0;
    bool same_instant = false;  ///< False if `color` is an older picture shown again, or missing.
    bool color_again = false;   ///< True if an earlier pair had this colour picture.
  };

  static SensorTimes times_of(const Pair& pair) {
    return {std::chrono::microseconds(pair.timestamp_us), std::chrono::microseconds(pair.color_timestamp_us),
            pair.color_again};
  }

  /// Pictures within half a depth period belong to one instant. Colour up to `reuse_us` away is
  /// repeated.
  FrameSynchronizer(std::int64_t half_period_us, std::int64_t reuse_us)
      : half_period_us_(half_period_us), reuse_us_(reuse_us) {}

  /// Adds a picture. Timestamps of a stream must not decrease; both streams have one time zero.
  void add_depth(std::int64_t timestamp_us, Picture picture) {
    depth_.push_back({timestamp_us, std::move(picture), false});
  }
  void add_color(std::int64_t timestamp_us, Picture picture) {
    color_.push_back({timestamp_us, std::move(picture), false});
    if (color_.size() > kMaxWaiting) drop_oldest_color();
  }

  bool has_depth() const { return !depth_.empty(); }
  std::size_t waiting() const { return depth_.size(); }

  /// Takes the oldest depth picture. Returns nothing if `may_wait` is true and colour is still
  /// missing.
  std::optional<Pair> take(bool may_wait) {
    if (depth_.empty()) return std::nullopt;
    const std::int64_t timestamp = depth_.front().timestamp_us;
    Stamped* nearest = nullptr;
    bool passed_by = false;
    for (Stamped& color : color_) {
      const auto distance = [&](const Stamped& c) { return std::abs(c.timestamp_us - timestamp); };
      if (!nearest || distance(color) <= distance(*nearest)) nearest = &color;
      passed_by = passed_by || color.timestamp_us > timestamp + half_period_us_;
    }
    const bool same_instant = nearest && std::abs(nearest->timestamp_us - timestamp) <= half_period_us_;
    if (!same_instant && !passed_by && may_wait) return std::nullopt;

    Pair pair{timestamp, std::move(depth_.front().picture), std::nullopt, 0, same_instant, false};
    depth_.pop_front();
    if (nearest && std::abs(nearest->timestamp_us - timestamp) <= reuse_us_) {
      pair.color = nearest->picture;
      pair.color_timestamp_us = nearest->timestamp_us;
      pair.color_again = std::exchange(nearest->used, true);
    }
    // The newest colour picture stays, so that it can be repeated for the next depth picture.
    while (color_.size() > 1 && color_[1].timestamp_us <= timestamp + half_period_us_) drop_oldest_color();
    return pair;
  }

  /// Number of colour pictures that were dropped without being in a pair.
  std::uint64_t unused_color() const { return unused_color_; }

 private:
  struct Stamped {
    std::int64_t timestamp_us = 0;
    Picture picture;
    bool used = false;
  };
  static constexpr std::size_t kMaxWaiting = 8;

  void drop_oldest_color() {
    if (!color_.front().used) ++unused_color_;
    color_.pop_front();
  }

  std::int64_t half_period_us_;
  std::int64_t reuse_us_;
  std::deque<Stamped> depth_;
  std::deque<Stamped> color_;
  std::uint64_t unused_color_ = 0;
};

}  // namespace copresence::sensor
