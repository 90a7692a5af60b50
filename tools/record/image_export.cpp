#include "tools/record/image_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <utility>

#include "capture_server/recording/oni_reader.h"
#include "render_client/decoding/frame_decoding.h"
#include "render_client/session/session_file.h"
#include "tools/record/export_folder.h"

namespace copresence::record {
namespace {

using recording::OniReader;
using std::chrono::microseconds;
using Kind = recording::RecordedStream::Kind;

/// The index of the entry nearest to `time`. Requires rising times, at least one.
std::size_t nearest(const std::vector<std::uint64_t>& times, std::uint64_t time) {
  const auto after = std::lower_bound(times.begin(), times.end(), time);
  if (after == times.begin()) return 0;
  const auto index = static_cast<std::size_t>(after - times.begin());
  if (after == times.end()) return index - 1;
  return time - times[index - 1] <= *after - time ? index - 1 : index;
}

class OniExport {
 public:
  OniExport(const ExportSettings& settings, OniReader reader)
      : settings_(settings), reader_(std::move(reader)) {}

  Result<ExportReport> run(const recording::ProgressReport& progress) {
    const recording::RecordingSummary& summary = reader_.summary();
    depth_ = summary.find(Kind::kDepth);
    color_ = summary.find(Kind::kColor);
    if (!depth_) return fail(ErrorCode::kInvalid, fmt::format("{}: has no depth", settings_.recording));
    zero_us_ = summary.unix_zero_us.value_or(0);
    auto folder = ExportFolder::create(settings_.out, settings_.format, camera(summary));
    if (!folder) return fail(folder.error());
    for (std::size_t i = 0; i < depth_->frames(); ++i) {
      const auto image = reader_.depth(i);
      if (!image) {
        ++damaged_;
        continue;
      }
      const auto pose = summary.camera_metadata ? summary.camera_metadata->world_from_camera : std::nullopt;
      if (auto added = folder->add_depth(time(*depth_, i), *image, pose); !added) return fail(added.error());
      if (settings_.format == ExportFormat::k7Scenes && color_ && color_->frames() > 0) {
        const std::size_t color = nearest(color_->timestamps_us, depth_->timestamps_us[i]);
        if (auto added = add_color(*folder, color); !added) return fail(added.error());
      }
      progress(static_cast<double>(i + 1) / static_cast<double>(depth_->frames()));
    }
    if (settings_.format == ExportFormat::kTum && color_) {
      for (std::size_t i = 0; i < color_->frames(); ++i) {
        if (auto added = add_color(*folder, i); !added) return fail(added.error());
      }
    }
    if (auto finished = folder->finish(); !finished) return fail(finished.error());
    ExportReport report{folder->depth_images(), folder->color_images(), {settings_.out}, {}};
    if (damaged_ > 0)
      report.remarks.push_back(fmt::format("{} pictures cannot be decoded and are left out", damaged_));
    return report;
  }

 private:
  recording::CameraMetadata camera(const recording::RecordingSummary& summary) const {
    if (summary.camera_metadata) return *summary.camera_metadata;
    recording::CameraMetadata camera;
    camera.model = nominal_kinect(depth_->width, depth_->height);
    camera.unit = depth_->unit;
    return camera;
  }

  microseconds time(const recording::RecordedStream& stream, std::size_t frame) const {
    return microseconds(zero_us_ + static_cast<std::int64_t>(stream.timestamps_us[frame]));
  }

  Result<void> add_color(ExportFolder& folder, std::size_t frame) {
    if (color_->codec == "JPEG") {
      const auto jpeg = reader_.payload(*color_, frame);
      if (jpeg) return folder.add_color(time(*color_, frame), *jpeg);
    } else if (const auto image = reader_.color(frame)) {
      return folder.add_color(time(*color_, frame), *image);
    }
    ++damaged_;
    return {};
  }

  const ExportSettings& settings_;
  OniReader reader_;
  const recording::RecordedStream* depth_ = nullptr;
  const recording::RecordedStream* color_ = nullptr;
  std::int64_t zero_us_ = 0;
  std::size_t damaged_ = 0;
};

recording::CameraMetadata camera_of(const StreamDescription& stream) {
  recording::CameraMetadata camera;
  camera.name = stream.camera;
  camera.model = stream.model;
  camera.registered = true;
  camera.unit = stream.unit;
  if (stream.has_pose) camera.world_from_camera = stream.world_from_camera;
  return camera;
}

/// Returns the first of NAME, "NAME (2)" and so on that is not taken, and takes it.
std::string take_name(const std::string& camera, std::set<std::string>& taken) {
  std::string name = camera;
  std::replace(name.begin(), name.end(), '/', '_');
  if (name.starts_with('.')) name.front() = '_';
  std::string free = name;
  for (int number = 2; !taken.insert(free).second; ++number) free = fmt::format("{} ({})", name, number);
  return free;
}

Result<void> export_stream(const session::SessionFile& file, const session::RecordedStream& stream,
                           ExportFolder& folder, std::size_t& damaged) {
  auto decoding = decoding::FrameDecoding::open(stream.description);
  if (!decoding) return fail(decoding.error());
  for (const session::RecordedFrame& recorded : stream.frames) {
    const auto encoded = file.read(recorded);
    decoding::FrameDecoding::Durations durations;
    const auto frame = encoded ? decoding->decode(*encoded, durations) : fail(encoded.error());
    if (!frame) {
      ++damaged;
      continue;
    }
    const auto time = std::chrono::duration_cast<microseconds>(recorded.time());
    const auto pose =
        stream.description.has_pose ? std::optional(frame->metadata.world_from_camera) : std::nullopt;
    if (auto added = folder.add_depth(time, frame->depth, pose); !added) return added;
    if (!frame->color) continue;
    if (auto added = folder.add_color(time, *frame->color); !added) return added;
  }
  return {};
}

Result<ExportReport> export_session(const ExportSettings& settings, const session::SessionFile& file,
                                    const recording::ProgressReport& progress) {
  ExportReport report;
  report.remarks = file.remarks();
  std::set<std::string> taken;
  std::size_t damaged = 0, index = 0;
  for (const session::RecordedCamera& camera : file.cameras()) {
    for (const session::RecordedStream& stream : camera.streams) {
      auto folder = ExportFolder::create(std::filesystem::path(settings.out) / take_name(camera.name, taken),
                                         settings.format, camera_of(stream.description));
      if (!folder) return fail(folder.error());
      if (auto done = export_stream(file, stream, *folder, damaged); !done) return fail(done.error());
      if (auto finished = folder->finish(); !finished) return fail(finished.error());
      report.depth_images += folder->depth_images();
      report.color_images += folder->color_images();
      report.folders.push_back(folder->path().string());
    }
    progress(static_cast<double>(++index) / static_cast<double>(file.cameras().size()));
  }
  if (damaged > 0)
    report.remarks.push_back(fmt::format("{} frames cannot be decoded and are left out", damaged));
  return report;
}

}  // namespace

Result<ExportReport> export_images(const ExportSettings& settings,
                                   const recording::ProgressReport& progress) {
  if (std::filesystem::path(settings.recording).extension() == ".mkv") {
    const auto file = session::SessionFile::open(settings.recording);
    if (!file) return fail(file.error());
    return export_session(settings, *file, progress);
  }
  auto reader = OniReader::open(settings.recording);
  if (!reader) return fail(reader.error());
  return OniExport(settings, std::move(*reader)).run(progress);
}

}  // namespace copresence::record
