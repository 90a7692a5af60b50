// A recording that a stranger wrote. The check must not crash, and what it accepts must be what it promises
// to those who play it.

#include <cmath>
#include <cstdlib>

#include "capture_server/recording/oni_check.h"

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
    require(std::isfinite(mean_period_us(stream)) && mean_period_us(stream) > 0);
    require(stream.frames_per_second > 0 && !stream.name.empty());
  }
  if (summary.camera_note) require(check(summary.camera_note->model).has_value());
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
  return 0;
}
