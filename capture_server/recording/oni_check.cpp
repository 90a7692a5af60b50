#include "capture_server/recording/oni_check.h"

#include <algorithm>

#include "capture_server/recording/input_file.h"
#include "capture_server/recording/record_bytes.h"
#include "capture_server/recording/record_walk.h"

namespace copresence::recording {

const RecordedStream* RecordingSummary::find(RecordedStream::Kind kind) const {
  const auto found =
      std::find_if(streams.begin(), streams.end(), [&](const auto& s) { return s.kind == kind; });
  return found == streams.end() ? nullptr : &*found;
}

double mean_period_us(const RecordedStream& stream) {
  const auto& times = stream.timestamps_us;
  if (times.size() >= 2 && times.back() > times.front()) {
    return static_cast<double>(times.back() - times.front()) / static_cast<double>(times.size() - 1);
  }
  return 1e6 / std::max(stream.frames_per_second, 1);
}

Result<RecordingSummary> check(const std::string& path) {
  const auto file = InputFile::open(path);
  if (!file) return fail(file.error());
  RecordBytes bytes = file->bytes();
  return RecordWalk(bytes, path).run();
}

Result<RecordingSummary> check(std::span<const std::uint8_t> bytes, std::string_view name) {
  RecordBytes reader(bytes.size(), [&](std::uint64_t offset, std::span<std::uint8_t> into) {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return true;
  });
  const std::string text(name);
  return RecordWalk(reader, text).run();
}

}  // namespace copresence::recording
