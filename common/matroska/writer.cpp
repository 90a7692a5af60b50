#include "common/matroska/writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "common/matroska/ebml.h"

namespace copresence::matroska {
namespace {

constexpr auto kNanosecondsPerTick = std::chrono::nanoseconds(Time(1)).count();
constexpr Time kLongestCluster = std::chrono::milliseconds(500);
constexpr std::size_t kVoidHeadBytes = 1 + kLongSizeBytes;
constexpr std::size_t kClusterHeadBytes = 4 + kLongSizeBytes;
constexpr std::uint64_t kVideoTrack = 1;
constexpr std::uint8_t kKeyframeFlag = 0x80;

void append_master(Bytes& out, Id id, const Bytes& children) {
  append_bytes(out, id, children);
}

Bytes ebml_header() {
  Bytes children;
  append_number(children, Id::kEbmlVersion, 1);
  append_number(children, Id::kEbmlReadVersion, 1);
  append_number(children, Id::kEbmlMaxIdLength, 4);
  append_number(children, Id::kEbmlMaxSizeLength, 8);
  append_text(children, Id::kDocType, "matroska");
  append_number(children, Id::kDocTypeVersion, 4);
  append_number(children, Id::kDocTypeReadVersion, 2);
  Bytes out;
  append_master(out, Id::kEbml, children);
  return out;
}

/// Matroska counts nanoseconds from the beginning of 2001 (UTC).
std::uint64_t matroska_date(std::chrono::system_clock::time_point instant) {
  using namespace std::chrono;
  constexpr sys_days kZero = 2001y / January / 1;
  return static_cast<std::uint64_t>(duration_cast<nanoseconds>(instant - kZero).count());
}

bool fits_block(Time from_cluster) {
  using Limits = std::numeric_limits<std::int16_t>;
  return from_cluster.count() >= Limits::min() && from_cluster.count() <= Limits::max();
}

}  // namespace

Result<Writer> Writer::begin(file::OutputFile file, Heading heading) {
  Writer writer(std::move(file), std::move(heading));
  Bytes start = ebml_header();
  append_id(start, Id::kSegment);
  append_long_size(start, kUnknownSize);
  writer.segment_at_ = start.size();
  // The padding is written now, so that a full disk cannot prevent a later change of the head.
  start.resize(start.size() + writer.heading_.head_bytes);
  if (auto written = writer.file_.append(start); !written) return fail(written.error());
  if (auto written = writer.write_head(); !written) return fail(written.error());
  return writer;
}

Result<std::uint64_t> Writer::add_track(Track track) {
  tracks_.push_back(std::move(track));
  if (auto written = write_head(); !written) {
    tracks_.pop_back();
    return fail(written.error());
  }
  return tracks_.size();
}

Result<void> Writer::add_attachment(Attachment attachment) {
  attachments_.push_back(std::move(attachment));
  auto written = write_head();
  if (!written) attachments_.pop_back();
  return written;
}

Result<void> Writer::write(Time time, std::span<const Block> blocks) {
  assert(time.count() >= 0);
  if (cluster_at_ && (time - cluster_time_ > kLongestCluster || !fits_block(time - cluster_time_))) {
    if (auto ended = end_cluster(); !ended) return ended;
  }
  if (!cluster_at_) {
    if (auto begun = begin_cluster(time); !begun) return begun;
  }
  const auto from_cluster = static_cast<std::uint16_t>((time - cluster_time_).count());
  Bytes elements;
  for (const Block& block : blocks) {
    assert(block.track >= 1 && block.track <= tracks_.size());
    Bytes head;
    append_size(head, block.track);  // Track numbers are coded like sizes.
    head.push_back(static_cast<std::uint8_t>(from_cluster >> 8));
    head.push_back(static_cast<std::uint8_t>(from_cluster));
    head.push_back(block.is_keyframe ? kKeyframeFlag : 0);
    append_id(elements, Id::kSimpleBlock);
    append_size(elements, head.size() + block.bytes.size());
    elements.insert(elements.end(), head.begin(), head.end());
    elements.insert(elements.end(), block.bytes.begin(), block.bytes.end());
  }
  if (auto written = file_.append(elements); !written) return written;
  last_time_ = std::max(last_time_, time);
  for (const Block& block : blocks) {
    if (block.is_keyframe) cues_.push_back({block.track, time, *cluster_at_ - segment_at_});
  }
  return {};
}

Result<void> Writer::begin_cluster(Time time) {
  Bytes head;
  append_id(head, Id::kCluster);
  append_long_size(head, kUnknownSize);
  append_number(head, Id::kTimestamp, static_cast<std::uint64_t>(time.count()));
  const std::uint64_t at = file_.size();
  if (auto written = file_.append(head); !written) return written;
  cluster_at_ = at;
  cluster_time_ = time;
  return {};
}

Result<void> Writer::end_cluster() {
  if (!cluster_at_) return {};
  const std::uint64_t at = *std::exchange(cluster_at_, std::nullopt);
  Bytes size;
  append_long_size(size, file_.size() - at - kClusterHeadBytes);
  return file_.write_at(at + kClusterHeadBytes - kLongSizeBytes, size);
}

Result<void> Writer::finish() {
  if (auto ended = end_cluster(); !ended) return ended;
  const std::uint64_t end = file_.size();
  if (!cues_.empty() && file_.append(cue_list())) cues_at_ = end - segment_at_;
  is_finished_ = true;
  if (auto written = write_head(); !written) return written;
  Bytes size;
  append_long_size(size, file_.size() - segment_at_);
  if (auto written = file_.write_at(segment_at_ - kLongSizeBytes, size); !written) return written;
  return file_.close();
}

Result<void> Writer::write_head() {
  const Bytes information = this->information(), tracks = track_list(), attachments = attachment_list();
  // Positions have a fixed size, so the size of the list does not depend on them.
  const std::uint64_t begin = seek_head(0, 0, 0).size();
  Bytes head = seek_head(begin, begin + information.size(), begin + information.size() + tracks.size());
  for (const Bytes* part : {&information, &tracks, &attachments})
    head.insert(head.end(), part->begin(), part->end());
  if (head.size() + kVoidHeadBytes > heading_.head_bytes) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: the file has no room for another track; begin a new file", path()));
  }
  append_id(head, Id::kVoid);
  append_long_size(head, heading_.head_bytes - head.size() - kLongSizeBytes);
  return file_.write_at(segment_at_, head);
}

Bytes Writer::seek_head(std::uint64_t information, std::uint64_t tracks, std::uint64_t attachments) const {
  Bytes entries;
  const auto add = [&](Id id, std::uint64_t position) {
    Bytes entry, name;
    append_id(name, id);
    append_bytes(entry, Id::kSeekId, name);
    append_long_number(entry, Id::kSeekPosition, position);
    append_master(entries, Id::kSeek, entry);
  };
  add(Id::kInfo, information);
  add(Id::kTracks, tracks);
  if (!attachments_.empty()) add(Id::kAttachments, attachments);
  if (cues_at_ != 0) add(Id::kCues, cues_at_);
  Bytes out;
  append_master(out, Id::kSeekHead, entries);
  return out;
}

Bytes Writer::information() const {
  Bytes children;
  append_number(children, Id::kTimestampScale, kNanosecondsPerTick);
  append_text(children, Id::kMuxingApp, heading_.program);
  append_text(children, Id::kWritingApp, heading_.program);
  if (!heading_.title.empty()) append_text(children, Id::kTitle, heading_.title);
  if (heading_.began_at) append_long_number(children, Id::kDateUtc, matroska_date(*heading_.began_at));
  if (is_finished_) append_real(children, Id::kDuration, static_cast<double>(last_time_.count()));
  Bytes out;
  append_master(out, Id::kInfo, children);
  return out;
}

Bytes Writer::track_list() const {
  Bytes entries;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    Bytes video;
    append_number(video, Id::kPixelWidth, static_cast<std::uint64_t>(track.width));
    append_number(video, Id::kPixelHeight, static_cast<std::uint64_t>(track.height));
    Bytes entry;
    append_number(entry, Id::kTrackNumber, i + 1);
    append_number(entry, Id::kTrackUid, i + 1);
    append_number(entry, Id::kTrackType, kVideoTrack);
    append_number(entry, Id::kFlagDefault, track.is_default ? 1 : 0);
    append_number(entry, Id::kFlagLacing, 0);
    append_text(entry, Id::kName, track.name);
    append_text(entry, Id::kLanguage, "und");
    append_text(entry, Id::kCodecId, track.codec);
    if (track.frame_period.count() > 0)
      append_number(entry, Id::kDefaultDuration, static_cast<std::uint64_t>(track.frame_period.count()));
    append_bytes(entry, Id::kCodecPrivate, track.codec_private);
    append_master(entry, Id::kVideo, video);
    append_master(entries, Id::kTrackEntry, entry);
  }
  Bytes out;
  append_master(out, Id::kTracks, entries);
  return out;
}

Bytes Writer::attachment_list() const {
  Bytes entries;
  for (std::size_t i = 0; i < attachments_.size(); ++i) {
    const Attachment& attachment = attachments_[i];
    Bytes entry;
    append_text(entry, Id::kFileDescription, attachment.description);
    append_text(entry, Id::kFileName, attachment.name);
    append_text(entry, Id::kFileMediaType, attachment.media_type);
    append_number(entry, Id::kFileUid, i + 1);
    append_bytes(entry, Id::kFileData, attachment.bytes);
    append_master(entries, Id::kAttachedFile, entry);
  }
  Bytes out;
  if (!entries.empty()) append_master(out, Id::kAttachments, entries);
  return out;
}

Bytes Writer::cue_list() const {
  Bytes points;
  for (const Cue& cue : cues_) {
    Bytes positions, point;
    append_number(positions, Id::kCueTrack, cue.track);
    append_number(positions, Id::kCueClusterPosition, cue.cluster);
    append_number(point, Id::kCueTime, static_cast<std::uint64_t>(cue.time.count()));
    append_master(point, Id::kCueTrackPositions, positions);
    append_master(points, Id::kCuePoint, point);
  }
  Bytes out;
  append_master(out, Id::kCues, points);
  return out;
}

}  // namespace copresence::matroska
