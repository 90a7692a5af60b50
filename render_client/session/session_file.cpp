#include "render_client/session/session_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/bitstream/length_prefixed.h"
#include "common/text/excerpt.h"
#include "common/wire/stored_description.h"
#include "render_client/session/session_format.h"

namespace copresence::session {
namespace {

std::vector<matroska::BlockPlace> sorted(std::vector<matroska::BlockPlace> blocks) {
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return blocks;
}

}  // namespace

Result<SessionFile> SessionFile::open(const std::string& path) {
  auto file = matroska::Reader::open(path);
  if (!file) return fail(file.error());
  SessionFile session(path, std::move(*file));
  std::vector<RecordedStream> streams;
  for (const matroska::Attachment& attachment : session.file_.attachments()) {
    if (auto stream = session.read_stream(attachment)) streams.push_back(std::move(*stream));
  }
  std::stable_sort(streams.begin(), streams.end(),
                   [](const RecordedStream& a, const RecordedStream& b) { return a.begin() < b.begin(); });
  for (RecordedStream& stream : streams) session.add_to_camera(std::move(stream));
  if (session.file_.is_cut())
    session.remarks_.push_back(
        fmt::format("{}: ends early, or is damaged; it is replayed up to there", path));
  if (session.cameras_.empty()) {
    return fail(ErrorCode::kCorrupt,
                session.remarks_.empty()
                    ? fmt::format("{}: holds no session that can be replayed; give a file "
                                  "that render_client --record wrote",
                                  path)
                    : session.remarks_.front());
  }
  std::stable_sort(session.cameras_.begin(), session.cameras_.end(),
                   [](const RecordedCamera& a, const RecordedCamera& b) { return a.name < b.name; });
  session.begin_ = Time::max();
  for (const RecordedCamera& camera : session.cameras_) {
    session.begin_ = std::min(session.begin_, camera.streams.front().begin());
    session.end_ = std::max(session.end_, camera.streams.back().end());
  }
  return session;
}

std::optional<RecordedStream> SessionFile::read_stream(const matroska::Attachment& attachment) {
  if (!attachment.name.ends_with(kDescriptionSuffix)) return std::nullopt;
  const std::string label = attachment.name.substr(0, attachment.name.size() - kDescriptionSuffix.size());
  const auto depth = find_track(depth_track_name(label));
  auto description = wire::load_description(attachment.bytes);
  const auto leave_out = [&](std::string_view why) {
    remarks_.push_back(
        fmt::format("{}: camera \"{}\" cannot be replayed: {}", path_, text::excerpt(label), why));
    return std::nullopt;
  };
  if (!description) return leave_out(description.error().what);
  if (!depth) return leave_out("it has no track of depth");
  auto frames = pair_frames(*depth, find_track(color_track_name(label)));
  if (frames.empty()) return leave_out("it has no keyframe");
  return RecordedStream{std::move(*description), std::move(frames)};
}

std::optional<std::size_t> SessionFile::find_track(const std::string& name) const {
  const auto& tracks = file_.tracks();
  const auto found = std::find_if(tracks.begin(), tracks.end(),
                                  [&](const matroska::Track& track) { return track.name == name; });
  return found == tracks.end() ? std::nullopt
                               : std::optional(static_cast<std::size_t>(found - tracks.begin()));
}

std::vector<RecordedFrame> SessionFile::pair_frames(std::size_t depth,
                                                    std::optional<std::size_t> color) const {
  const auto depths = sorted(file_.blocks(depth));
  const auto colors = color ? sorted(file_.blocks(*color)) : std::vector<matroska::BlockPlace>();
  std::vector<RecordedFrame> frames;
  auto next_color = colors.begin();
  for (const matroska::BlockPlace& place : depths) {
    while (next_color != colors.end() && next_color->time < place.time) ++next_color;
    const bool has_color = next_color != colors.end() && next_color->time == place.time;
    if (frames.empty() && !place.is_keyframe) continue;
    frames.push_back({place, has_color ? std::optional(*next_color) : std::nullopt});
  }
  return frames;
}

void SessionFile::add_to_camera(RecordedStream stream) {
  // Two cameras may have the same name. Streams of one camera never overlap in time.
  const auto follows = [&](const RecordedCamera& camera) {
    return camera.name == stream.description.camera && camera.streams.back().end() < stream.begin();
  };
  const auto camera = std::find_if(cameras_.begin(), cameras_.end(), follows);
  if (camera != cameras_.end()) {
    camera->streams.push_back(std::move(stream));
  } else {
    std::string name = stream.description.camera;
    cameras_.push_back({std::move(name), {}});
    cameras_.back().streams.push_back(std::move(stream));
  }
}

Result<EncodedFrame> SessionFile::read(const RecordedFrame& frame) const {
  EncodedFrame encoded;
  encoded.keyframe = frame.is_keyframe();
  const auto read_unit = [&](const matroska::BlockPlace& place,
                             std::vector<std::uint8_t>& into) -> Result<void> {
    const auto bytes = file_.read(place);
    if (!bytes) return fail(bytes.error());
    auto unit = bitstream::from_length_prefixed(*bytes);
    if (!unit) return fail(unit.error());
    into = std::move(*unit);
    return {};
  };
  if (auto read = read_unit(frame.depth, encoded.depth); !read) return fail(read.error());
  if (!frame.color) return encoded;
  if (auto read = read_unit(*frame.color, encoded.color); !read) return fail(read.error());
  return encoded;
}

}  // namespace copresence::session
