// A recording that a stranger wrote. The check must not crash, and what it accepts must be what it promises
// to those who play it; nor must the search for whole frames in it.

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "capture_server/recording/oni_check.h"
#include "capture_server/recording/oni_recovery.h"

namespace copresence::recording {
namespace {

void require(bool promise) {
  if (!promise) std::abort();
}

void require_promises(const RecordingSummary& summary) {
  const RecordedStream* depth = summary.find(RecordedStream::Kind::kDepth);
  require(depth && depth->frames() > 0);
  require(summary.duration.count() > 0);
  for (const RecordedStream& stream : summary.streams) {
    require(stream.width >= 2 && stream.width % 2 == 0 && stream.height >= 2 && stream.height % 2 == 0);
    require(std::isfinite(usual_period_us(stream)) && usual_period_us(stream) > 0);
    require(stream.frames_per_second > 0 && !stream.name.empty());
  }
  if (summary.camera_metadata) require(check(summary.camera_metadata->model).has_value());
}

// What the repair would keep lies in the file, in order.
void require_whole_frames(std::span<const std::uint8_t> data) {
  RecordBytes bytes(data.size(), [&](std::uint64_t offset, std::span<std::uint8_t> into) {
    std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return true;
  });
  const auto found = recover(bytes, "fuzz.oni");
  if (!found) return;
  require(!found->streams.empty() && found->whole_until <= data.size());
  for (const RecoveredStream& stream : found->streams) {
    std::uint32_t last = 0;
    for (const RecoveredFrame& frame : stream.frames) {
      require(frame.number > last && frame.position + frame.bytes() <= found->whole_until);
      last = frame.number;
    }
  }
}

}  // namespace
}  // namespace copresence::recording

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto summary = copresence::recording::check(std::span(data, size), "fuzz.oni");
  if (summary) {
    copresence::recording::require_promises(*summary);
  } else {
    copresence::recording::require(!summary.error().what.empty());
  }
  copresence::recording::require_whole_frames(std::span(data, size));
  return 0;
}
