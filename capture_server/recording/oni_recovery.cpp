#include "capture_server/recording/oni_recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "capture_server/recording/oni_footer.h"
#include "capture_server/recording/oni_format.h"

namespace copresence::recording {
namespace {

constexpr std::uint32_t kMaxPayload = 1 << 26;
constexpr std::uint32_t kSearchStep = 1 << 16;

struct Record : RecordHead {
  std::uint64_t at = 0, end = 0;  // Positions in the file.
};

class Search {
 public:
  Search(RecordBytes& bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Result<RecoveredRecording> run() {
    const auto header = bytes_.at(0, kHeaderBytes);
    if (!header || !std::equal(std::begin(kFileMagic), std::end(kFileMagic), header->begin())) {
      return fail(ErrorCode::kCorrupt, fmt::format("{}: not an OpenNI recording; give an .oni file", name_));
    }
    found_.is_old = is_old_version(FieldReader(header->subspan(sizeof(kFileMagic))).u64());
    if (found_.is_old) record_bytes_ = kOldRecordBytes;
    std::uint64_t at = kHeaderBytes;
    while (at < bytes_.size()) {
      const auto record = record_at(at);
      if (record && take(*record)) {
        at = record->end;
        found_.whole_until = at;
        if (record->type == RecordType::kEnd && !frame_at(at)) break;  // Only zeros may follow.
        continue;
      }
      const auto next = next_frame(at + 1);
      if (!next) break;
      found_.gaps.push_back({at, *next});
      at = *next;
    }
    if (found_.streams.empty()) {
      return fail(
          ErrorCode::kCorrupt,
          fmt::format("{}: no stream's definition is whole in it, so nothing of it can be saved", name_));
    }
    if (found_.first_frame_position == 0) found_.first_frame_position = found_.whole_until;
    return std::move(found_);
  }

 private:
  std::optional<Record> record_at(std::uint64_t at) {
    const auto bytes = bytes_.at(at, record_bytes_);
    if (!bytes) return std::nullopt;
    Record record{parse_record_head(*bytes), at};
    if (!record.has_payload()) record.payload_bytes = 0;
    if (record.magic != kRecordMagic || record.type < RecordType::kNodeAddedOld ||
        record.type > RecordType::kSeekTable || record.fields_bytes < record_bytes_ ||
        record.fields_bytes > kMaxFields || record.payload_bytes > kMaxPayload) {
      return std::nullopt;
    }
    record.end = at + record.fields_bytes + record.payload_bytes;
    if (record.end > bytes_.size()) return std::nullopt;
    return record;
  }

  RecoveredStream* find(std::uint32_t node) {
    const auto found = std::find_if(found_.streams.begin(), found_.streams.end(),
                                    [&](const RecoveredStream& s) { return s.node == node; });
    return found == found_.streams.end() ? nullptr : &*found;
  }

  // Returns the record as a frame if it is the next frame of its stream. Else returns nothing.
  std::optional<RecoveredFrame> frame_of(const Record& record) {
    const RecoveredStream* stream = find(record.node);
    if (record.type != RecordType::kNewData || !stream || record.fields_bytes != frame_head_bytes()) {
      return std::nullopt;
    }
    const auto bytes = bytes_.at(record.at, frame_head_bytes());
    if (!bytes) return std::nullopt;
    FieldReader fields(bytes->subspan(record_bytes_));
    const std::uint64_t timestamp = fields.u64();
    const std::uint32_t number = fields.u32();
    const std::uint32_t last = stream->frames.empty() ? 0 : stream->frames.back().number;
    if (number <= last || number - last > kMostFrames) return std::nullopt;
    return RecoveredFrame{timestamp, record.at, number, record.fields_bytes, record.payload_bytes};
  }

  bool frame_at(std::uint64_t at) {
    const auto record = record_at(at);
    return record && frame_of(*record);
  }

  // Returns the position of the next frame at or after `from`.
  std::optional<std::uint64_t> next_frame(std::uint64_t from) {
    const std::uint8_t magic[] = {kRecordMagic & 0xff, kRecordMagic >> 8 & 0xff, kRecordMagic >> 16 & 0xff,
                                  0};
    while (from + frame_head_bytes() <= bytes_.size()) {
      const auto left = bytes_.size() - from;
      const auto bytes =
          bytes_.at(from, static_cast<std::uint32_t>(std::min<std::uint64_t>(left, kSearchStep)));
      if (!bytes) return std::nullopt;
      const auto found = std::search(bytes->begin(), bytes->end(), std::begin(magic), std::end(magic));
      if (found == bytes->end()) {
        from += bytes->size() - (bytes->size() > sizeof(magic) ? sizeof(magic) - 1 : 0);
        if (bytes->size() == left) return std::nullopt;
        continue;
      }
      from += static_cast<std::uint64_t>(found - bytes->begin());
      if (frame_at(from)) return from;
      ++from;
    }
    return std::nullopt;
  }

  bool take(const Record& record) {
    switch (record.type) {
      case RecordType::kNewData: {
        const auto frame = frame_of(record);
        if (!frame) return false;
        if (found_.first_frame_position == 0) found_.first_frame_position = record.at;
        find(record.node)->frames.push_back(*frame);
        found_.has_end = false;
        end_begins_.reset();
        return true;
      }
      case RecordType::kNodeAdded:
      case RecordType::kNodeAddedOld:
      case RecordType::kNodeAddedOlder:
        return take_node(record);
      case RecordType::kNodeRemoved:
        if (!end_begins_) {
          end_begins_ = record.at;
          found_.has_seek_tables = false;
        }
        return true;
      case RecordType::kSeekTable:
        found_.has_seek_tables = true;
        return true;
      case RecordType::kEnd:
        found_.has_end = true;
        found_.end_position = end_begins_.value_or(record.at);
        if (end_begins_ && record.end - *end_begins_ == footer_bytes(found_.streams.size())) {
          found_.footers.push_back(*end_begins_);
        }
        end_begins_.reset();
        return true;
      default:
        return true;
    }
  }

  bool take_node(const Record& record) {
    if (!found_.is_old && record.type != RecordType::kNodeAdded) return false;
    const auto bytes = bytes_.at(record.at, record.fields_bytes);
    if (!bytes || find(record.node)) return false;
    FieldReader fields(bytes->subspan(record_bytes_));
    fields.text();
    const auto type = static_cast<NodeType>(fields.u32());
    fields.u32();  // The codec.
    if (!fields.ok() || (!found_.is_old && record.fields_bytes < kRecordBytes + kNodeCountsBytes))
      return false;
    const std::uint64_t counts_at = found_.is_old ? 0 : record.at + record.fields_bytes - kNodeCountsBytes;
    found_.largest_node = std::max(found_.largest_node, record.node);
    found_.streams.push_back({record.node, type, record.at, counts_at, {}});
    return true;
  }

  std::uint32_t frame_head_bytes() const { return record_bytes_ + kFrameFieldBytes; }

  RecordBytes& bytes_;
  const std::string& name_;
  std::uint32_t record_bytes_ = kRecordBytes;
  RecoveredRecording found_;
  std::optional<std::uint64_t> end_begins_;  // Position of the first kNodeRemoved after the last frame.
};

}  // namespace

std::vector<FramePlace> RecoveredStream::places() const {
  std::vector<FramePlace> places;
  places.reserve(frames.size());
  for (const RecoveredFrame& frame : frames) places.push_back({frame.timestamp_us, frame.position});
  return places;
}

std::uint64_t RecoveredRecording::frames() const {
  std::uint64_t sum = 0;
  for (const RecoveredStream& stream : streams) sum += stream.frames.size();
  return sum;
}

std::uint64_t RecoveredRecording::frames(NodeType type) const {
  std::uint64_t sum = 0;
  for (const RecoveredStream& stream : streams) sum += stream.type == type ? stream.frames.size() : 0;
  return sum;
}

Result<RecoveredRecording> recover(RecordBytes& bytes, const std::string& name) {
  return Search(bytes, name).run();
}

}  // namespace copresence::recording
