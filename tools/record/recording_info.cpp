#include "tools/record/recording_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture_server/recording/oni_reader.h"
#include "capture_server/recording/oni_recovery.h"
#include "common/file/input_file.h"
#include "tools/record/time_reading.h"

namespace copresence::record {
namespace {

using recording::OniReader;
using recording::RecordedStream;
using Kind = RecordedStream::Kind;

constexpr double kPause = 1.5;  // Shortest pause, as a multiple of the usual period.
constexpr std::size_t kPausesShown = 10;

const char* name(Kind kind) {
  return kind == Kind::kDepth ? "depth" : kind == Kind::kColor ? "color" : "infrared";
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

StreamInfo describe(const RecordedStream& stream) {
  StreamInfo info;
  info.kind = stream.kind;
  info.name = stream.name;
  info.codec = stream.codec;
  info.width = stream.width;
  info.height = stream.height;
  info.frames = stream.frames();
  info.frames_missing = stream.last_frame - info.frames;
  info.nominal_fps = stream.frames_per_second;
  const double period_us = usual_period_us(stream);
  info.fps = 1e6 / period_us;
  if (stream.frames() == 0) return info;
  const auto& times = stream.timestamps_us;
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  info.seconds = (static_cast<double>(*last - *first) + period_us) * 1e-6;
  info.without_time = recording::steps_without_time(stream);
  // Sets the duration of playback. If at least a quarter of the times do not increase, the player
  // shows the frames one usual period apart.
  const bool has_times = 4 * info.without_time < times.size();
  if (!has_times) info.seconds = static_cast<double>(times.size()) * period_us * 1e-6;
  double bytes = 0;
  for (const auto& payload : stream.payloads) bytes += payload.bytes;
  info.mbps = bytes * 8e-6 / info.seconds;
  std::vector<double> periods;
  for (std::size_t i = 1; i < times.size(); ++i) {
    periods.push_back(static_cast<double>(times[i]) - static_cast<double>(times[i - 1]));
  }
  const double usual = median(periods);
  for (std::size_t i = 0; i < periods.size(); ++i) {
    if (periods[i] <= kPause * usual) continue;
    info.pauses.push_back(
        {i + 1, (static_cast<double>(times[i]) - static_cast<double>(times[0])) * 1e-6, periods[i] * 1e-3});
  }
  return info;
}

std::optional<DepthInfo> depth_statistics(const OniReader& reader,
                                          const recording::ProgressReport& progress) {
  const RecordedStream& stream = *reader.summary().find(Kind::kDepth);
  DepthInfo info;
  info.unit_mm = static_cast<int>(stream.unit) * 1e-3;
  std::vector<bool> seen(65536, false);
  std::uint64_t holes = 0, pixels = 0;
  for (std::size_t i = 0; i < stream.frames(); ++i) {
    const auto depth = reader.depth(i);
    progress(static_cast<double>(i + 1) / static_cast<double>(stream.frames()));
    if (!depth) {
      if (depth.error().code == ErrorCode::kUnsupported) return std::nullopt;
      ++info.damaged;
      continue;
    }
    for (const std::uint16_t value : depth->pixels()) {
      holes += value == 0;
      seen[value] = true;
    }
    pixels += depth->pixels().size();
  }
  if (pixels) info.holes_percent = 100.0 * static_cast<double>(holes) / static_cast<double>(pixels);
  for (std::size_t value = 1; value < seen.size(); ++value) {
    if (!seen[value]) continue;
    const double metres = static_cast<double>(value) * info.unit_mm * 1e-3;
    if (info.levels++ == 0) info.nearest_m = metres;
    info.farthest_m = metres;
  }
  return info;
}

std::optional<double> color_after_depth(const RecordedStream& depth, const RecordedStream* color) {
  if (!color || color->frames() == 0) return std::nullopt;
  std::vector<double> distances;
  const auto& times = color->timestamps_us;
  for (const std::uint64_t time : depth.timestamps_us) {
    const auto next = std::lower_bound(times.begin(), times.end(), time);
    double nearest = 1e18;
    for (auto candidate : {next, next == times.begin() ? next : next - 1}) {
      if (candidate == times.end()) continue;
      const double distance = static_cast<double>(*candidate) - static_cast<double>(time);
      if (std::abs(distance) < std::abs(nearest)) nearest = distance;
    }
    distances.push_back(nearest * 1e-3);
  }
  return median(distances);
}

std::optional<std::int64_t> start_of(const recording::RecordingSummary& summary) {
  if (!summary.unix_zero_us) return std::nullopt;
  std::optional<std::uint64_t> first;
  for (const RecordedStream& stream : summary.streams) {
    for (const std::uint64_t time : stream.timestamps_us) first = std::min(first.value_or(time), time);
  }
  return *summary.unix_zero_us + static_cast<std::int64_t>(first.value_or(0));
}

}  // namespace

Result<RecordingInfo> read_info(const std::string& path, const recording::ProgressReport& progress) {
  const auto reader = OniReader::open(path);
  if (!reader) return fail(reader.error());
  RecordingInfo info;
  info.file = path;
  info.bytes = reader->file_bytes();
  const recording::RecordingSummary& summary = reader->summary();
  for (const RecordedStream& stream : summary.streams) {
    info.streams.push_back(describe(stream));
    if (stream.kind == Kind::kDepth) info.seconds = info.streams.back().seconds;
  }
  info.depth = depth_statistics(*reader, progress);
  info.color_after_depth_ms = color_after_depth(*summary.find(Kind::kDepth), summary.find(Kind::kColor));
  info.camera = summary.camera_metadata;
  info.started_unix_us = start_of(summary);
  if (const auto file = file::InputFile::open(path, "an .oni recording")) {
    recording::RecordBytes bytes(*file);
    const auto found = recording::recover(bytes, path);
    info.finished = found && found->has_end && (found->has_seek_tables || found->is_old);
  }
  return info;
}

std::string to_table(const RecordingInfo& info) {
  std::string text = fmt::format(
      "{}: {:.1f} s, {:.1f} MB{}\n{}", info.file, info.seconds, static_cast<double>(info.bytes) * 1e-6,
      info.finished ? "" : ", incomplete: its recorder was stopped (use record repair)",
      info.started_unix_us ? "" : "\n");
  if (info.started_unix_us)
    text += "began " + utc_text(std::chrono::microseconds(*info.started_unix_us)) + "\n\n";
  text += fmt::format("{:<9}{:>10}{:>7}{:>8}{:>9}{:>8}{:>8}{:>12}{:>9}\n", "stream", "size", "coding",
                      "frames", "missing", "rate/s", "gaps", "longest ms", "Mbit/s");
  for (const StreamInfo& stream : info.streams) {
    double longest = 0;
    for (const auto& pause : stream.pauses) longest = std::max(longest, pause.ms);
    text += fmt::format("{:<9}{:>10}{:>7}{:>8}{:>9}{:>8.2f}{:>8}{:>12}{:>9.1f}\n", name(stream.kind),
                        fmt::format("{}x{}", stream.width, stream.height), stream.codec, stream.frames,
                        stream.frames_missing, stream.fps, stream.pauses.size(),
                        stream.pauses.empty() ? "-" : fmt::format("{:.0f}", longest), stream.mbps);
  }
  text += '\n';
  if (info.depth) {
    text += fmt::format("depth in {} mm: {:.1f} % holes, {} levels from {:.3f} to {:.3f} m{}\n",
                        info.depth->unit_mm, info.depth->holes_percent, info.depth->levels,
                        info.depth->nearest_m, info.depth->farthest_m,
                        info.depth->damaged ? fmt::format(", {} damaged frames", info.depth->damaged) : "");
  } else {
    text += "only OpenNI2 can decode this depth codec: holes and levels are not known\n";
  }
  if (info.color_after_depth_ms) {
    text += fmt::format("the nearest colour frame is {:.1f} ms after a depth frame (median)\n",
                        *info.color_after_depth_ms);
  }
  if (info.camera) {
    const CameraModel& m = info.camera->model;
    text += fmt::format(
        "camera \"{}\": fx {:.1f}, fy {:.1f}, cx {:.1f}, cy {:.1f}, colour {}registered, {} pose\n",
        info.camera->name, m.fx, m.fy, m.cx, m.cy, info.camera->registered ? "" : "not ",
        info.camera->world_from_camera ? "with a" : "no");
  }
  for (const StreamInfo& stream : info.streams) {
    if (stream.without_time) {
      text += fmt::format(
          "{}: the times of {} frames stand still or go back; they are played at {:.4g} frames/s\n",
          name(stream.kind), stream.without_time, stream.fps);
    }
    for (std::size_t i = 0; i < std::min(stream.pauses.size(), kPausesShown); ++i) {
      const auto& pause = stream.pauses[i];
      text += fmt::format("{}: no frame for {:.0f} ms after frame {}, at {:.2f} s\n", name(stream.kind),
                          pause.ms, pause.after_frame, pause.at_s);
    }
    if (stream.pauses.size() > kPausesShown) {
      text += fmt::format("{}: ... and {} more\n", name(stream.kind), stream.pauses.size() - kPausesShown);
    }
  }
  return text;
}

std::string to_json(const RecordingInfo& info) {
  using nlohmann::ordered_json;
  ordered_json root{
      {"file", info.file}, {"bytes", info.bytes}, {"finished", info.finished}, {"duration_s", info.seconds}};
  if (info.started_unix_us) {
    root["started_unix_s"] = static_cast<double>(*info.started_unix_us) * 1e-6;
    root["started_utc"] = utc_text(std::chrono::microseconds(*info.started_unix_us));
  }
  root["streams"] = ordered_json::array();
  for (const StreamInfo& stream : info.streams) {
    ordered_json out{{"kind", name(stream.kind)},
                     {"name", stream.name},
                     {"codec", stream.codec},
                     {"width", stream.width},
                     {"height", stream.height},
                     {"frames", stream.frames},
                     {"frames_missing", stream.frames_missing},
                     {"fps_nominal", stream.nominal_fps},
                     {"fps", stream.fps},
                     {"frames_without_time", stream.without_time},
                     {"duration_s", stream.seconds},
                     {"mbps", stream.mbps}};
    out["gaps"] = ordered_json::array();
    for (const auto& pause : stream.pauses) {
      out["gaps"].push_back({{"after_frame", pause.after_frame}, {"at_s", pause.at_s}, {"ms", pause.ms}});
    }
    if (stream.kind == Kind::kDepth && info.depth) {
      out["unit_mm"] = info.depth->unit_mm;
      out["holes_percent"] = info.depth->holes_percent;
      out["levels"] = info.depth->levels;
      out["nearest_m"] = info.depth->nearest_m;
      out["farthest_m"] = info.depth->farthest_m;
      out["frames_damaged"] = info.depth->damaged;
    }
    root["streams"].push_back(std::move(out));
  }
  if (info.color_after_depth_ms) root["color_after_depth_ms"] = *info.color_after_depth_ms;
  if (info.camera) root["camera"] = ordered_json::parse(recording::to_json(*info.camera));
  return root.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace copresence::record
