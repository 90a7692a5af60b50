#include "capture_server/recording/oni_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace copresence::recording {
namespace {

// OpenNI2's player has a table with one entry per node id, up to the largest node in the header.
constexpr std::uint32_t kMaxNodes = 32;
// Longer names do not fit into the player's fields.
constexpr std::size_t kMaxName = 79;

// The distinct depths of a table of 16-bit numbers, ascending. The result is empty for other bytes.
std::vector<std::uint16_t> levels_in(std::span<const std::uint8_t> table) {
  constexpr std::size_t kMostTableBytes = 2 * 65536;
  std::vector<std::uint16_t> levels;
  if (table.size() % 2 || table.size() > kMostTableBytes) return levels;
  for (std::size_t i = 0; i < table.size(); i += 2) {
    const auto level = static_cast<std::uint16_t>(table[i] | table[i + 1] << 8);
    if (level) levels.push_back(level);
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

}  // namespace

tl::unexpected<Error> OniParser::damaged(std::uint64_t at, const std::string& what) const {
  return fail(
      ErrorCode::kCorrupt,
      fmt::format("{}: damaged at byte {}: {}; take another copy of the file or run record repair on it",
                  name_, at, what));
}

tl::unexpected<Error> OniParser::cut_off(std::uint64_t at) const {
  return fail(
      ErrorCode::kCorrupt,
      fmt::format("{}: cut off: the record at byte {} goes on beyond the file's end at {}, so its recorder "
                  "was stopped or the copy is incomplete; copy it again, or run record repair on it",
                  name_, at, bytes_.size()));
}

tl::unexpected<Error> OniParser::unusable(const std::string& what) const {
  return fail(ErrorCode::kUnsupported, fmt::format("{}: {}", name_, what));
}

tl::unexpected<Error> OniParser::placed(std::uint64_t at, const Error& error) const {
  return error.code == ErrorCode::kUnsupported ? unusable(error.what) : damaged(at, error.what);
}

OniParser::Node* OniParser::find(std::uint32_t id) {
  const auto found = nodes_.find(id);
  return found == nodes_.end() || found->second.life == Node::Life::kRemoved ? nullptr : &found->second;
}

Result<RecordingSummary> OniParser::run() {
  if (auto done = header(); !done) return fail(done.error());
  while (true) {
    const auto record = next_record();
    if (!record) return fail(record.error());
    if (record->type == RecordType::kEnd) {
      if (configuring_) return damaged(record->at, "a stream's definition breaks off here");
      return summary();  // OpenNI2's own recorder leaves zeros after the end.
    }
    if (auto done = read(*record); !done) return fail(done.error());
  }
}

Result<void> OniParser::header() {
  const auto bytes = bytes_.at(0, kHeaderBytes);
  if (!bytes || !std::equal(std::begin(kFileMagic), std::end(kFileMagic), bytes->begin())) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: {}not an OpenNI recording; give an .oni file", name_,
                                                 bytes_.size() ? "" : "empty, "));
  }
  FieldReader fields(bytes->subspan(sizeof(kFileMagic)));
  const std::uint64_t version = fields.u64();
  max_timestamp_ = fields.u64();
  max_node_ = fields.u32();
  is_old_ = is_old_version(version);
  if (version != kFileVersion && !is_old_) {
    return unusable(fmt::format(
        "written in version {}.{}.{}.{} of the format, only 1.0.0.4 to 1.0.1.0 can be read; record it "
        "again with OpenNI 2",
        version & 0xff, version >> 8 & 0xff, version >> 16 & 0xffff, version >> 32));
  }
  if (max_timestamp_ > kMaxTimestamp) return damaged(kHeaderTimestampAt, "its largest time is impossible");
  if (max_node_ >= kMaxNodes) {
    return damaged(kHeaderNodeAt, fmt::format("it claims node ids up to {}, a recording has at most {}",
                                              max_node_, kMaxNodes));
  }
  position_ = kHeaderBytes;
  return {};
}

Result<OniParser::Record> OniParser::next_record() {
  const std::uint64_t at = position_;
  const auto bytes = bytes_.at(at, record_bytes());
  if (!bytes) {
    return fail(
        ErrorCode::kCorrupt,
        fmt::format(
            "{}: cut off at byte {}: there is no end record, so its recorder was stopped or the copy is "
            "incomplete; copy it again, or run record repair on it",
            name_, bytes_.size()));
  }
  Record record{parse_record_head(*bytes), at};
  if (record.magic != kRecordMagic) return damaged(at, "no record begins here");
  if (record.fields_bytes < record_bytes() || record.fields_bytes > kMaxFields) {
    return damaged(at, fmt::format("a record's fields take {} bytes", record.fields_bytes));
  }
  // Only frames and seek tables have a payload. The player ignores the payload size of other
  // records, except while it counts the frames of an old file.
  if (!record.has_payload()) {
    if (is_old_ && record.payload_bytes) return damaged(at, "a record has a payload that it cannot have");
    record.payload_bytes = 0;
  }
  const std::uint64_t end = at + record.fields_bytes + record.payload_bytes;
  if (end > bytes_.size()) return cut_off(at);
  position_ = end;
  return record;
}

Result<void> OniParser::read(const Record& record) {
  // The player reads a stream's definition to its end before anything else. Frames within the
  // definition are lost, and an end within it makes the player recurse without limit.
  const bool defines =
      (record.type >= RecordType::kIntProperty && record.type <= RecordType::kGeneralProperty) ||
      record.type == RecordType::kNodeAdded || record.type == RecordType::kNodeAddedOlder ||
      record.type == RecordType::kNodeAddedOld || record.type == RecordType::kStateReady ||
      record.type == RecordType::kDataBegin;
  if (configuring_ && !defines) return damaged(record.at, "a stream's definition breaks off here");
  const auto bytes = bytes_.at(record.at, record.fields_bytes);
  if (!bytes) return cut_off(record.at);
  const FieldReader fields(bytes->subspan(record_bytes()));
  switch (record.type) {
    case RecordType::kNodeAddedOld:
      if (!is_old_) return damaged(record.at, "a stream's definition has the form of an older version");
      [[fallthrough]];
    case RecordType::kNodeAdded:
    case RecordType::kNodeAddedOlder:
      return node_added(record, fields);
    case RecordType::kIntProperty:
    case RecordType::kRealProperty:
    case RecordType::kStringProperty:
    case RecordType::kGeneralProperty:
      return property(record, fields);
    case RecordType::kStateReady:
      return state_ready(record);
    case RecordType::kNodeRemoved:
      return node_removed(record);
    case RecordType::kDataBegin:
      return data_begin(record, fields);
    case RecordType::kNewData:
      return new_data(record, fields);
    case RecordType::kSeekTable:
      return seek_table(record);
    default:
      return damaged(record.at,
                     fmt::format("record type {} is unknown", static_cast<std::uint32_t>(record.type)));
  }
}

Result<void> OniParser::node_added(const Record& record, FieldReader fields) {
  const std::string name(fields.text());
  const auto type = static_cast<NodeType>(fields.u32());
  std::string codec;
  for (std::uint32_t fourcc = fields.u32(), i = 0; i < 4; ++i, fourcc >>= 8)
    codec += static_cast<char>(fourcc & 0xff);
  std::uint32_t frames = 0;
  std::uint64_t seek_table_at = 0;
  if (record.type != RecordType::kNodeAddedOld) {
    frames = fields.u32();
    fields.u64();  // First and last timestamp, which the frames also have.
    fields.u64();
  }
  if (record.type == RecordType::kNodeAdded) seek_table_at = is_old_ ? fields.u32() : fields.u64();
  if (!fields.whole() || name.empty() || name.size() > kMaxName) {
    return damaged(record.at, "a stream's definition is invalid");
  }
  if (record.node > max_node_ || nodes_.contains(record.node)) {
    return damaged(record.at, fmt::format("node {} is defined twice or out of the range given", record.node));
  }
  for (const auto& [id, other] : nodes_) {
    if (other.stream.name == name) return damaged(record.at, fmt::format("two nodes are named {}", name));
  }
  Node node;
  node.is_stream = type == NodeType::kDepth || type == NodeType::kImage || type == NodeType::kInfrared;
  node.stream.name = name;
  node.stream.codec = codec;
  node.frames_claimed = frames;
  node.is_counted_at_data = record.type == RecordType::kNodeAddedOld;
  node.seek_table_at = frames ? seek_table_at : 0;
  if (node.is_stream) {
    using Kind = RecordedStream::Kind;
    node.stream.kind = type == NodeType::kDepth   ? Kind::kDepth
                       : type == NodeType::kImage ? Kind::kColor
                                                  : Kind::kInfrared;
    if (frames > kMostFrames)
      return damaged(record.at, fmt::format("stream {} claims {} frames", name, frames));
    if (data_begun_)
      return damaged(record.at, fmt::format("stream {} is defined after data has begun", name));
    for (const auto& [id, other] : nodes_) {
      if (other.is_stream && other.stream.kind == node.stream.kind) {
        return unusable(
            fmt::format("it has two {} streams, {} and {}; record the cameras into files of their own",
                        recording::name(node.stream.kind), other.stream.name, name));
      }
    }
  }
  nodes_.emplace(record.node, std::move(node));
  ++configuring_;
  return {};
}

Result<void> OniParser::property(const Record& record, FieldReader fields) {
  const std::string_view key = fields.text();
  const auto value = fields.blob();
  const bool is_number = record.type == RecordType::kIntProperty || record.type == RecordType::kRealProperty;
  if (!fields.whole() || key.empty() || key.size() > kMaxName || (is_number && value.size() != 8) ||
      (record.type == RecordType::kStringProperty && (value.empty() || value.back() != 0))) {
    return damaged(record.at, "a property is invalid");
  }
  Node* node = find(record.node);
  if (!node) {
    return damaged(record.at, fmt::format("property {} belongs to no stream", key));
  }
  if (key == kCameraMetadataProperty) {
    auto note = parse_camera_metadata({reinterpret_cast<const char*>(value.data()), value.size()});
    if (!note)
      return damaged(record.at, fmt::format("the camera metadata cannot be read ({})", note.error().what));
    camera_metadata_ = std::move(*note);
    return {};
  }
  if (key == kUnixZeroProperty) {
    FieldReader number(value);
    const auto unix_zero = std::bit_cast<std::int64_t>(number.u64());
    const auto limit = static_cast<std::int64_t>(kMaxTimestamp);
    if (record.type != RecordType::kGeneralProperty || !number.whole() || unix_zero < -limit ||
        unix_zero > limit) {
      return damaged(record.at, "its start time is invalid");
    }
    unix_zero_us_ = unix_zero;
    return {};
  }
  if (!node->is_stream) return {};
  if (key == kDisparityTableProperty) {
    if (node->life != Node::Life::kReady) node->stream.levels = levels_in(value);
    return {};
  }
  const StreamFormat before = node->format;
  if (!node->format.apply(node->stream.kind, record.type, key, value)) {
    return damaged(record.at, fmt::format("{} of stream {} is wrong", key, node->stream.name));
  }
  if (node->life == Node::Life::kReady && node->format != before) {
    return unusable(
        fmt::format("stream {} changes its {} in the middle, at byte {}; record the parts into files of "
                    "their own",
                    node->stream.name, key, record.at));
  }
  return {};
}

Result<void> OniParser::state_ready(const Record& record) {
  Node* node = find(record.node);
  if (!node) return damaged(record.at, "an unknown stream is declared ready");
  if (node->life == Node::Life::kReady) return {};
  node->life = Node::Life::kReady;
  --configuring_;
  if (!node->is_stream) return {};
  if (auto described = node->format.describe(node->stream); !described) {
    return placed(record.at, described.error());
  }
  node->max_payload = node->format.max_payload(node->stream.codec, node->stream.kind);
  return {};
}

Result<void> OniParser::node_removed(const Record& record) {
  Node* node = find(record.node);
  if (!node) return damaged(record.at, fmt::format("node {} is removed, but is not defined", record.node));
  node->life = Node::Life::kRemoved;
  return {};
}

Result<void> OniParser::data_begin(const Record& record, FieldReader fields) {
  const std::uint32_t frames = fields.u32();
  fields.u64();  // Last timestamp. Newer recorders leave both fields empty.
  Node* node = find(record.node);
  if (!fields.whole() || !node || !node->is_stream)
    return damaged(record.at, "data begins for an unknown stream");
  if (std::exchange(node->is_counted_at_data, false)) {
    if (frames > kMostFrames)
      return damaged(record.at, fmt::format("stream {} claims {} frames", node->stream.name, frames));
    node->frames_claimed = frames;
  }
  data_begun_ = true;
  return {};
}

Result<void> OniParser::new_data(const Record& record, FieldReader fields) {
  const std::uint64_t timestamp = fields.u64();
  const std::uint32_t number = fields.u32();
  Node* node = find(record.node);
  if (!fields.whole() || !node || !node->is_stream || !data_begun_) {
    return damaged(record.at, "a frame of an unknown stream");
  }
  RecordedStream& stream = node->stream;
  if (number <= stream.last_frame || number > node->frames_claimed) {
    return damaged(record.at, fmt::format("stream {} has frame {}, then frame {}, of {} frames", stream.name,
                                          stream.last_frame, number, node->frames_claimed));
  }
  // Frames with decreasing times are played in the file's order. The player stops reading at a time
  // beyond the header's largest.
  if (timestamp > max_timestamp_) {
    return damaged(record.at, fmt::format("frame {} of stream {} has a time beyond the recording's end",
                                          number, stream.name));
  }
  const bool raw = stream.codec == "NONE";
  if (record.payload_bytes > node->max_payload || (raw && record.payload_bytes != node->max_payload)) {
    return damaged(record.at,
                   fmt::format("frame {} of stream {} takes {} bytes, {} {} expected", number, stream.name,
                               record.payload_bytes, raw ? "exactly" : "at most", node->max_payload));
  }
  stream.last_frame = number;
  stream.timestamps_us.push_back(timestamp);
  stream.payloads.push_back({record.at + record.fields_bytes, record.payload_bytes});
  return {};
}

Result<void> OniParser::seek_table(const Record& record) {
  const auto found = nodes_.find(record.node);  // The stream's node may have been removed.
  if (found == nodes_.end()) return damaged(record.at, "a seek table of an unknown stream");
  Node& node = found->second;
  const std::uint64_t entry = is_old_ ? kOldSeekEntryBytes : kSeekEntryBytes;
  const std::uint64_t expected = entry * (std::uint64_t{node.frames_claimed} + 1);
  if (record.at == node.seek_table_at && record.payload_bytes == expected) node.has_seek_table = true;
  return {};
}

Result<RecordingSummary> OniParser::summary() {
  RecordingSummary summary;
  for (auto& [id, node] : nodes_) {
    if (node.seek_table_at && !node.has_seek_table) {  // The player reads the table when it opens the file.
      return damaged(node.seek_table_at,
                     fmt::format("the seek table of stream {} is not here", node.stream.name));
    }
    if (node.is_stream) summary.streams.push_back(std::move(node.stream));
  }
  const RecordedStream* depth = summary.find(RecordedStream::Kind::kDepth);
  if (!depth) return unusable("there is no depth stream in it; record depth too");
  if (depth->frames() == 0) return unusable("there is no depth frame in it; record it again");
  if (camera_metadata_ &&
      (camera_metadata_->model.width != depth->width || camera_metadata_->model.height != depth->height ||
       camera_metadata_->unit != depth->unit)) {
    return unusable("its camera metadata has another size or unit than its depth stream; record it again");
  }
  summary.camera_metadata = std::move(camera_metadata_);
  summary.unix_zero_us = unix_zero_us_;
  const auto [first, last] = std::minmax_element(depth->timestamps_us.begin(), depth->timestamps_us.end());
  summary.duration = std::chrono::microseconds(static_cast<std::int64_t>(*last - *first) +
                                               static_cast<std::int64_t>(usual_period_us(*depth)));
  return summary;
}

}  // namespace copresence::recording
