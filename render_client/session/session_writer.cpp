#include "render_client/session/session_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "common/bitstream/length_prefixed.h"
#include "common/file/output_file.h"
#include "common/version.h"
#include "common/wire/stored_description.h"
#include "render_client/session/session_format.h"

namespace copresence::session {
namespace {

/// Room for the tracks and descriptions of about a hundred streams.
constexpr std::size_t kHeadBytes = 128 * 1024;

/// Returns the frame period. It is 0 for a rate that no player could show.
std::chrono::nanoseconds frame_period(double frames_per_second) {
  return std::chrono::nanoseconds(std::llround(1e9 / frames_per_second));
}

bool has_keyframe(std::span<const bitstream::Nal> nals) {
  return std::any_of(nals.begin(), nals.end(),
                     [](const bitstream::Nal& nal) { return nal.type() == bitstream::NalType::kIdrSlice; });
}

}  // namespace

Result<SessionWriter> SessionWriter::create(const std::string& path, Instant began_at) {
  auto output = file::OutputFile::create_numbered(path);
  if (!output) return fail(output.error());
  const auto age = std::chrono::steady_clock::now() - began_at;
  matroska::Writer::Heading heading{
      .title = "Copresence session",
      .program = fmt::format("render_client {}", kVersion),
      .began_at = std::chrono::system_clock::now() -
                  std::chrono::duration_cast<std::chrono::system_clock::duration>(age),
      .head_bytes = kHeadBytes};
  auto file = matroska::Writer::begin(std::move(*output), std::move(heading));
  if (!file) return fail(file.error());
  return SessionWriter(std::move(*file), began_at);
}

Result<void> SessionWriter::write(std::size_t camera,
                                  const std::shared_ptr<const StreamDescription>& description,
                                  const EncodedFrame& frame, Instant captured_at) {
  const auto depth = bitstream::split_access_unit(frame.depth);
  if (!depth) return fail(depth.error());
  Stream& of = stream(camera, description);
  if (!of.depth_track) {
    if (auto added = add_depth_track(of, *depth); !added) return added;
  }
  std::vector<matroska::Writer::Block> blocks;
  const auto depth_bytes = bitstream::to_length_prefixed(*depth);
  blocks.push_back({*of.depth_track, frame.keyframe, depth_bytes});
  std::vector<std::uint8_t> color_bytes;
  if (!frame.color.empty()) {
    const auto color = bitstream::split_access_unit(frame.color);
    if (!color) return fail(color.error());
    if (!of.color_track) {
      if (auto added = add_color_track(of, *color); !added) return added;
    }
    color_bytes = bitstream::to_length_prefixed(*color);
    blocks.push_back({*of.color_track, has_keyframe(*color), color_bytes});
  }
  // Depth and colour of a frame have the same time, and no two frames of a stream have. Only so a
  // replay can pair them.
  const matroska::Time time =
      std::max(std::chrono::floor<matroska::Time>(captured_at - began_at_), of.next_time);
  if (auto written = file_.write(time, blocks); !written) return written;
  of.next_time = time + matroska::Time(1);
  ++frames_;
  return {};
}

SessionWriter::Stream& SessionWriter::stream(std::size_t camera,
                                             const std::shared_ptr<const StreamDescription>& description) {
  // Only the camera's newest stream can continue, so that its streams do not overlap in time.
  const auto newest = std::find_if(streams_.rbegin(), streams_.rend(),
                                   [&](const Stream& stream) { return stream.camera == camera; });
  if (newest != streams_.rend() &&
      (newest->description == description || *newest->description == *description)) {
    return *newest;
  }
  streams_.push_back({camera, description, free_label(description->camera), {}, {}, {}});
  return streams_.back();
}

std::string SessionWriter::free_label(const std::string& camera) const {
  // Labels become file names when attachments are extracted.
  std::string name = camera;
  std::replace(name.begin(), name.end(), '/', '_');
  std::string label = name;
  const auto is_taken = [&](const Stream& stream) { return stream.label == label; };
  for (int number = 2; std::any_of(streams_.begin(), streams_.end(), is_taken); ++number)
    label = fmt::format("{} ({})", name, number);
  return label;
}

Result<void> SessionWriter::add_depth_track(Stream& stream, Nals first) {
  const StreamDescription& description = *stream.description;
  auto configuration = bitstream::avc_configuration(first, description.codec.format);
  if (!configuration) return fail(ErrorCode::kCorrupt, "a stream that does not begin with a keyframe");
  if (auto added = file_.add_attachment({.name = description_name(stream.label),
                                         .description = "Copresence stream description",
                                         .media_type = "application/octet-stream",
                                         .bytes = wire::store_description(description)});
      !added) {
    return added;
  }
  const auto track = file_.add_track({.name = depth_track_name(stream.label),
                                      .codec_private = std::move(*configuration),
                                      .width = description.model.width,
                                      .height = description.model.height,
                                      .frame_period = frame_period(description.frames_per_second),
                                      .is_default = false});
  if (!track) return fail(track.error());
  stream.depth_track = *track;
  return {};
}

Result<void> SessionWriter::add_color_track(Stream& stream, Nals first) {
  const StreamDescription& description = *stream.description;
  auto configuration = bitstream::avc_configuration(first, PixelFormat::kYuv420);
  if (!configuration) return fail(ErrorCode::kCorrupt, "colour that does not begin with a keyframe");
  const auto track = file_.add_track({.name = color_track_name(stream.label),
                                      .codec_private = std::move(*configuration),
                                      .width = description.model.width,
                                      .height = description.model.height,
                                      .frame_period = frame_period(description.frames_per_second)});
  if (!track) return fail(track.error());
  stream.color_track = *track;
  return {};
}

}  // namespace copresence::session
