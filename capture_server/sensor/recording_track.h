#pragma once

// One stream's place in a recording that may be played again and again: which of its pictures came, and which did not.
//
// Thread: a value.

#include <algorithm>
#include <cstdint>

namespace copresence::sensor {

/// Pictures count from 1 in every pass.
class RecordingTrack {
 public:
  /// `last`: number of a pass's last picture. `duration_us`: of one pass.
  RecordingTrack(std::uint64_t last, std::int64_t duration_us) : last_(last), duration_us_(duration_us) {}

  std::uint64_t index() const { return index_; }  ///< of the picture that came last
  std::uint64_t pass() const { return pass_; }    ///< of that picture, from 0
  std::uint64_t last() const { return last_; }
  bool at_end() const { return index_ >= last_; }
  std::int64_t timestamp_us() const {
    return timestamp_us_;
  }  ///< over all passes: it goes on over the seam and never back

  /// A picture came, with its number and time in its pass. Returns how many are missing between it and the one before.
  std::uint64_t advance(std::uint64_t number, std::int64_t time_in_pass_us) {
    const std::uint64_t next = std::max<std::uint64_t>(number, 1);
    std::uint64_t missing = 0;
    if (next <= index_) missing = begin_pass(pass_ + 1);
    missing += next - index_ - 1;
    index_ = next;
    timestamp_us_ =
        std::max(timestamp_us_, time_in_pass_us + static_cast<std::int64_t>(pass_) * duration_us_);
    return missing;
  }

  /// The player has come to this pass, picture or no picture. Returns how many are missing of those before.
  std::uint64_t begin_pass(std::uint64_t pass) {
    std::uint64_t missing = 0;
    for (; pass_ < pass; ++pass_) {
      missing += last_ - std::min(index_, last_);
      index_ = 0;
    }
    return missing;
  }

 private:
  std::uint64_t last_;
  std::int64_t duration_us_;
  std::uint64_t index_ = 0;
  std::uint64_t pass_ = 0;
  std::int64_t timestamp_us_ = 0;
};

}  // namespace copresence::sensor
