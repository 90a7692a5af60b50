#include "capture_server/recording/oni_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "capture_server/recording/oni_format.h"
#include "capture_server/recording/oni_parser.h"
#include "capture_server/recording/record_bytes.h"
#include "common/file/input_file.h"

namespace copresence::recording {

const RecordedStream* RecordingSummary::find(RecordedStream::Kind kind) const {
  const auto found =
      std::find_if(streams.begin(), streams.end(), [&](const auto& s) { return s.kind == kind; });
  return found == streams.end() ? nullptr : &*found;
}

std::size_t steps_without_time(const RecordedStream& stream) {
  const auto& times = stream.timestamps_us;
  std::size_t steps = 0;
  for (std::size_t i = 1; i < times.size(); ++i) steps += times[i] <= times[i - 1];
  return steps;
}

double usual_period_us(const RecordedStream& stream) {
  const auto& times = stream.timestamps_us;
  const double nominal = 1e6 / std::max(stream.frames_per_second, 1);
  // If more than a fourth of the times do not increase, no step is a usable frame period.
  if (times.size() < 2 || 4 * steps_without_time(stream) > times.size() - 1) return nominal;
  std::vector<std::uint64_t> steps;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) steps.push_back(times[i] - times[i - 1]);
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  double sum = 0;
  std::size_t count = 0;
  for (const std::uint64_t step : steps) {
    // If times are rounded, the steps between them alternate around their mean. Much longer steps
    // are pauses and much shorter ones are errors, so both are left out.
    if (2 * step < *middle || step > *middle + *middle / 2) continue;
    sum += static_cast<double>(step);
    ++count;
  }
  const double period = sum / static_cast<double>(count);
  return period < 1e6 / kFastestRate ? nominal : period;
}

Result<void> check_playable(const RecordedStream& depth, std::string_view name) {
  const double period_s = usual_period_us(depth) * 1e-6;
  if (period_s <= 1 / kSlowestRate) return {};
  return fail(
      ErrorCode::kUnsupported,
      fmt::format(
          "{}: a depth frame every {:.3g} s, but a recording is played at {} to {} frames a second; if "
          "its times are in another unit, make it again with record from-images --times",
          name, period_s, kSlowestRate, kFastestRate));
}

Result<RecordingSummary> check(const std::string& path) {
  const auto file = file::InputFile::open(path, "an .oni recording");
  if (!file) return fail(file.error());
  RecordBytes bytes(*file);
  return OniParser(bytes, path).run();
}

Result<void> check_written(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  const auto summary = check(path);
  if (!summary) return fail(summary.error());
  return check_playable(*summary->find(RecordedStream::Kind::kDepth), path);
}

Result<RecordingSummary> check(std::span<const std::uint8_t> bytes, std::string_view name) {
  RecordBytes reader(bytes.size(), [&](std::uint64_t offset, std::span<std::uint8_t> into) {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return true;
  });
  const std::string text(name);
  return OniParser(reader, text).run();
}

}  // namespace copresence::recording
