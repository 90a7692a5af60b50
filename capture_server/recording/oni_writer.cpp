#include "capture_server/recording/oni_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "capture_server/recording/depth_16z.h"
#include "capture_server/recording/oni_format.h"
#include "capture_server/recording/stream_format.h"

namespace copresence::recording {
namespace {

using Bytes = RecordBytesOut;

RecordedStream::FieldOfView view_of(const CameraModel& model) {
  return {2 * std::atan(0.5 * model.width / model.fx), 2 * std::atan(0.5 * model.height / model.fy)};
}

// Rejects early what check() would reject in the finished file.
Result<void> check_stream(RecordedStream::Kind kind, const CameraModel& model, const OniContent& content) {
  if (!is_sane(view_of(model))) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "a camera of {}x{} pixels with fx {:g} and fy {:g} has no field of view that a camera can "
            "have; check its intrinsics",
            model.width, model.height, model.fx, model.fy));
  }
  const bool is_depth = kind == RecordedStream::Kind::kDepth;
  StreamFormat format;
  format.width = static_cast<std::uint32_t>(model.width);
  format.height = static_cast<std::uint32_t>(model.height);
  format.frames_per_second = static_cast<std::uint32_t>(content.frames_per_second);
  format.has_cropping = true;
  format.has_max_depth = true;
  RecordedStream stream;
  stream.kind = kind;
  stream.name = is_depth ? "of depth" : "of colour";
  stream.codec = "NONE";
  return format.describe(stream);
}

Result<void> check_content(const OniContent& content) {
  if (auto usable = check(content.camera.model); !usable) return fail(usable.error());
  if (content.jpeg_quality < 1 || content.jpeg_quality > 100) {
    return fail(ErrorCode::kInvalid, "the JPEG quality of a recording must be from 1 to 100");
  }
  if (content.frames_per_second < 1 || content.frames_per_second > 1000) {
    return fail(ErrorCode::kInvalid, "the frame rate of a recording must be from 1 to 1000");
  }
  if (content.camera.color) {
    if (auto usable = check(content.camera.color->model); !usable) return fail(usable.error());
  }
  if (auto plays = check_stream(RecordedStream::Kind::kDepth, content.camera.model, content); !plays)
    return plays;
  if (!content.color) return {};
  const CameraModel& color = content.camera.color ? content.camera.color->model : content.camera.model;
  return check_stream(RecordedStream::Kind::kColor, color, content);
}

}  // namespace

Result<OniWriter> OniWriter::create(const std::string& path, const OniContent& content,
                                    file::Existing existing) {
  if (auto sensible = check_content(content); !sensible) return fail(sensible.error());
  return begin(content, file::OutputFile::create(path, existing));
}

Result<OniWriter> OniWriter::create_numbered(const std::string& path, const OniContent& content) {
  if (auto sensible = check_content(content); !sensible) return fail(sensible.error());
  return begin(content, file::OutputFile::create_numbered(path));
}

Result<OniWriter> OniWriter::begin(const OniContent& content, Result<file::OutputFile> file) {
  if (!file) return fail(file.error());
  const std::string path = file->path();
  OniWriter writer(path, content, std::move(*file));
  Bytes bytes = file_header(0, content.color ? 2 : 1);
  std::vector<Stream*> streams{&writer.depth_};
  if (content.color) streams.push_back(&writer.color_);
  for (Stream* stream : streams) writer.append_definition(bytes, *stream);
  for (const Stream* stream : streams) {
    append_record(bytes, RecordType::kStateReady, stream->node, {});
    append_record(bytes, RecordType::kDataBegin, stream->node, Bytes(12, 0xFF));
  }
  if (auto written = writer.file_.append(bytes); !written) return fail(written.error());
  if (content.unix_zero_us) {
    if (auto noted = writer.note_unix_zero(*content.unix_zero_us); !noted) return fail(noted.error());
  }
  return writer;
}

Result<void> OniWriter::note_unix_zero(std::int64_t unix_zero_us) {
  assert(depth_.frames.empty() && color_.frames.empty());
  Bytes value, record;
  append_number(value, std::bit_cast<std::uint64_t>(unix_zero_us), 8);
  append_general(record, depth_.node, kUnixZeroProperty, value);
  return file_.append(record);
}

const CameraModel& OniWriter::camera_of(const Stream& stream) const {
  const CameraMetadata& note = content_.camera;
  return &stream == &color_ && note.color ? note.color->model : note.model;
}

std::uint16_t OniWriter::largest_depth() const {
  return content_.max_depth.value_or(
      content_.camera.unit == DepthUnit::kMillimetre ? kMaxDepthMillimetre : kMaxDepth100Micrometres);
}

// Appends the properties in the order of OpenNI's recorder. Players need three of these properties.
// Without xnDeviceMaxDepth a 16zT node does not open. Without xnCropping every frame is dropped.
// Without xnFOV points cannot be converted to the world.
void OniWriter::append_definition(Bytes& bytes, Stream& stream) {
  const CameraModel& model = camera_of(stream);
  const bool is_depth = &stream == &depth_;
  const std::uint32_t codec = is_depth ? (content_.depth == DepthCoding::k16z ? kCodec16z : kCodecNone)
                                       : (content_.color == ColorCoding::kJpeg ? kCodecJpeg : kCodecNone);
  stream.added_position = bytes.size();
  append_node_added(bytes, stream.node, is_depth ? "Depth" : "Image",
                    is_depth ? NodeType::kDepth : NodeType::kImage, codec);
  stream.counts_position = bytes.size() - kNodeCountsBytes;
  const auto pixels = static_cast<std::uint64_t>(model.width) * static_cast<std::uint64_t>(model.height);
  const auto integer = [&](std::string_view key, std::uint64_t value) {
    append_integer(bytes, stream.node, key, value);
  };
  Bytes mode;
  append_number(mode, static_cast<std::uint64_t>(model.width), 4);
  append_number(mode, static_cast<std::uint64_t>(model.height), 4);
  append_number(mode, static_cast<std::uint64_t>(content_.frames_per_second), 4);
  Bytes field_of_view;
  const RecordedStream::FieldOfView view = view_of(model);
  append_number(field_of_view, std::bit_cast<std::uint64_t>(view.horizontal), 8);
  append_number(field_of_view, std::bit_cast<std::uint64_t>(view.vertical), 8);
  const OniPixelFormat format = !is_depth ? OniPixelFormat::kRgb888
                                : content_.camera.unit == DepthUnit::kMillimetre
                                    ? OniPixelFormat::kDepthMillimetre
                                    : OniPixelFormat::kDepth100Micrometres;

  integer("oniRequiredFrameSize", pixels * (is_depth ? 2 : 3));
  integer("xnIsGenerating", 1);
  if (is_depth) integer("xnDeviceMaxDepth", largest_depth());
  integer("xnSupportedMapOutputModesCount", 1);
  append_general(bytes, stream.node, "xnSupportedMapOutputModes", mode);
  append_general(bytes, stream.node, "xnMapOutputMode", mode);
  integer("xnPixelFormat", is_depth ? 4 : 1);
  integer("oniPixelFormat", static_cast<std::uint64_t>(format));
  append_general(bytes, stream.node, "xnFOV", field_of_view);
  integer("Cropping", 1);
  append_general(bytes, stream.node, "xnCropping", Bytes(12, 0));
  integer("Mirror", 1);
  integer("xnMirror", 0);
  if (is_depth) {
    const std::string note = to_json(content_.camera);
    append_general(bytes, stream.node, kCameraMetadataProperty, Bytes(note.begin(), note.end()));
  }
}

Result<void> OniWriter::write_depth(std::chrono::microseconds timestamp, const DepthImage& depth) {
  const CameraModel& model = content_.camera.model;
  if (depth.width() != model.width || depth.height() != model.height) {
    return fail(ErrorCode::kInvalid, path_ + ": a depth picture does not have the recording's size");
  }
  const std::uint16_t largest = *std::max_element(depth.pixels().begin(), depth.pixels().end());
  if (largest > largest_depth()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: a depth of {} does not fit into a recording of depths up to {}", path_,
                            largest, largest_depth()));
  }
  payload_.clear();
  if (content_.depth == DepthCoding::k16z) {
    if (auto coded = append_depth_16z(depth, payload_); !coded) return fail(coded.error());
  } else {
    for (const std::uint16_t value : depth.pixels()) append_number(payload_, value, 2);
  }
  return append_frame(depth_, timestamp, payload_);
}

Result<void> OniWriter::write_color(std::chrono::microseconds timestamp, const ColorImage& color) {
  assert(content_.color);
  const CameraModel& model = camera_of(color_);
  if (color.width() != model.width || color.height() != model.height) {
    return fail(ErrorCode::kInvalid, path_ + ": a colour picture does not have the recording's size");
  }
  if (content_.color == ColorCoding::kRaw) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(color.data());
    return append_frame(color_, timestamp, {first, color.pixels().size_bytes()});
  }
  if (auto coded = jpeg_.encode(color, content_.jpeg_quality, payload_); !coded) {
    return fail(coded.error().code, path_ + ": a colour picture cannot be coded: " + coded.error().what);
  }
  return append_frame(color_, timestamp, payload_);
}

Result<void> OniWriter::write_jpeg(std::chrono::microseconds timestamp, std::span<const std::uint8_t> jpeg) {
  assert(content_.color == ColorCoding::kJpeg);
  return append_frame(color_, timestamp, jpeg);
}

Result<void> OniWriter::append_frame(Stream& stream, std::chrono::microseconds timestamp,
                                     std::span<const std::uint8_t> payload) {
  if (timestamp.count() < 0 || (!stream.frames.empty() && static_cast<std::uint64_t>(timestamp.count()) <
                                                              stream.frames.back().timestamp_us)) {
    return fail(ErrorCode::kInvalid, path_ + ": a frame lies before the one written before it");
  }
  if (static_cast<std::uint64_t>(timestamp.count()) > kMaxTimestamp) {
    return fail(ErrorCode::kInvalid, path_ + ": a frame's time lies more than two thousand years after zero");
  }
  if (stream.frames.size() >= kMostFrames) {
    return fail(
        ErrorCode::kUnavailable,
        fmt::format("{}: a recording holds {} frames at most; begin another one", path_, kMostFrames));
  }
  const auto timestamp_us = static_cast<std::uint64_t>(timestamp.count());
  const std::uint64_t at = file_.size();
  record_.clear();
  append_frame_head(record_, stream.node, timestamp_us, static_cast<std::uint32_t>(stream.frames.size() + 1),
                    payload.size(), stream.frames.empty() ? 0 : stream.frames.back().position);
  record_.insert(record_.end(), payload.begin(), payload.end());
  if (auto written = file_.append(record_); !written) return written;
  stream.frames.push_back({timestamp_us, at});
  frames_since_ = true;
  return {};
}

Result<void> OniWriter::end(SeekTables seek_tables) {
  std::vector<FooterStream> streams;
  for (const Stream* stream : {&depth_, &color_}) {
    if (stream == &color_ && !content_.color) continue;
    streams.push_back({stream->node, stream->added_position, stream->counts_position, stream->frames});
  }
  const auto earlier = end_at_ ? std::vector{*end_at_} : std::vector<std::uint64_t>{};
  const auto at = write_footer(file_, streams, seek_tables, earlier);
  if (!at) return fail(at.error());
  end_at_ = *at;
  frames_since_ = false;
  return {};
}

Result<void> OniWriter::checkpoint() {
  return frames_since_ ? end(SeekTables::kNo) : Result<void>();
}

Result<void> OniWriter::finish() {
  if (auto ended = end(SeekTables::kYes); !ended) {
    if (frames_since_ || !end_at_) {
      if (auto without = end(SeekTables::kNo); !without) return without;
    }
  }
  return file_.close();
}

}  // namespace copresence::recording
