#include "capture_server/recording/oni_writer.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "capture_server/recording/depth_16z.h"
#include "capture_server/recording/oni_format.h"

namespace copresence::recording {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
void append_u32(Bytes& bytes, std::uint64_t value) {
  append(bytes, value, 4);
}
void append_u64(Bytes& bytes, std::uint64_t value) {
  append(bytes, value, 8);
}

void append_text(Bytes& bytes, std::string_view text) {
  append_u32(bytes, text.size() + 1);
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.push_back(0);
}

void append_record(Bytes& bytes, RecordType type, std::uint32_t node, const Bytes& fields,
                   std::size_t payload_bytes = 0, std::uint64_t undo_position = 0) {
  append_u32(bytes, kRecordMagic);
  append_u32(bytes, static_cast<std::uint32_t>(type));
  append_u32(bytes, node);
  append_u32(bytes, kRecordBytes + fields.size());
  append_u32(bytes, payload_bytes);
  append_u64(bytes, undo_position);
  bytes.insert(bytes.end(), fields.begin(), fields.end());
}

void append_integer(Bytes& bytes, std::uint32_t node, std::string_view key, std::uint64_t value) {
  Bytes fields;
  append_text(fields, key);
  append_u32(fields, 8);
  append_u64(fields, value);
  append_record(bytes, RecordType::kIntProperty, node, fields);
}

void append_general(Bytes& bytes, std::uint32_t node, std::string_view key,
                    std::span<const std::uint8_t> value) {
  Bytes fields;
  append_text(fields, key);
  append_u32(fields, value.size());
  fields.insert(fields.end(), value.begin(), value.end());
  append_record(bytes, RecordType::kGeneralProperty, node, fields);
}

Bytes header(std::uint64_t largest_timestamp, std::uint32_t largest_node) {
  Bytes bytes(std::begin(kFileMagic), std::end(kFileMagic));
  append(bytes, 1, 1);
  append(bytes, 0, 1);
  append(bytes, 1, 2);
  append_u32(bytes, 0);
  append_u64(bytes, largest_timestamp);
  append_u32(bytes, largest_node);
  return bytes;
}

std::uint16_t largest_depth(DepthUnit unit) {
  return unit == DepthUnit::kMillimetre ? kMaxDepthMillimetre : kMaxDepth100Micrometres;
}

}  // namespace

Result<OniWriter> OniWriter::create(const std::string& path, const OniContent& content) {
  if (auto usable = check(content.camera.model); !usable) return fail(usable.error());
  if (content.jpeg_quality < 1 || content.jpeg_quality > 100) {
    return fail(ErrorCode::kInvalid, "the JPEG quality of a recording must be from 1 to 100");
  }
  if (content.frames_per_second < 1 || content.frames_per_second > 1000) {
    return fail(ErrorCode::kInvalid, "the frame rate of a recording must be from 1 to 1000");
  }
  std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "wb"));
  if (!file) {
    return fail(ErrorCode::kUnavailable, path + ": cannot be written: " + std::strerror(errno));
  }
  OniWriter writer(path, content, std::move(file));
  writer.pending_ = header(0, content.color ? 2 : 1);

  std::vector<Stream*> streams{&writer.depth_};
  if (content.color) streams.push_back(&writer.color_);
  Bytes& bytes = writer.pending_;
  for (Stream* stream : streams) {
    stream->added_position = bytes.size();
    writer.append_node(*stream, 0);
    writer.append_properties(*stream);
  }
  for (const Stream* stream : streams) {
    append_record(bytes, RecordType::kStateReady, stream->node, {});
    append_record(bytes, RecordType::kDataBegin, stream->node, Bytes(12, 0xFF));
  }
  if (auto written = writer.flush(); !written) return fail(written.error());
  return writer;
}

void OniWriter::append_node(const Stream& stream, std::uint64_t seek_table_position) {
  const bool is_depth = stream.node == depth_.node;
  const std::uint32_t codec = is_depth ? (content_.depth == DepthCoding::k16z ? kCodec16z : kCodecNone)
                                       : (content_.color == ColorCoding::kJpeg ? kCodecJpeg : kCodecNone);
  Bytes fields;
  append_text(fields, is_depth ? "Depth" : "Image");
  append_u32(fields, static_cast<std::uint32_t>(is_depth ? NodeType::kDepth : NodeType::kImage));
  append_u32(fields, codec);
  append_u32(fields, stream.frames.size());
  append_u64(fields, stream.frames.empty() ? 0 : stream.frames.front().timestamp_us);
  append_u64(fields, stream.frames.empty() ? 0 : stream.frames.back().timestamp_us);
  append_u64(fields, seek_table_position);
  append_record(pending_, RecordType::kNodeAdded, stream.node, fields);
}

// The order is OpenNI's own. Without xnDeviceMaxDepth a 16zT node does not open, without xnCropping the
// player drops every frame, without xnFOV a point has no direction.
void OniWriter::append_properties(const Stream& stream) {
  const CameraModel& model = content_.camera.model;
  const bool is_depth = stream.node == depth_.node;
  const auto pixels = static_cast<std::uint64_t>(model.width) * static_cast<std::uint64_t>(model.height);
  const auto integer = [&](std::string_view key, std::uint64_t value) {
    append_integer(pending_, stream.node, key, value);
  };
  Bytes mode;
  append_u32(mode, model.width);
  append_u32(mode, model.height);
  append_u32(mode, content_.frames_per_second);
  Bytes field_of_view;
  append_u64(field_of_view, std::bit_cast<std::uint64_t>(2 * std::atan(0.5 * model.width / model.fx)));
  append_u64(field_of_view, std::bit_cast<std::uint64_t>(2 * std::atan(0.5 * model.height / model.fy)));
  const OniPixelFormat format = !is_depth ? OniPixelFormat::kRgb888
                                : content_.camera.unit == DepthUnit::kMillimetre
                                    ? OniPixelFormat::kDepthMillimetre
                                    : OniPixelFormat::kDepth100Micrometres;

  integer("oniRequiredFrameSize", pixels * (is_depth ? 2 : 3));
  integer("xnIsGenerating", 1);
  if (is_depth) integer("xnDeviceMaxDepth", largest_depth(content_.camera.unit));
  integer("xnSupportedMapOutputModesCount", 1);
  append_general(pending_, stream.node, "xnSupportedMapOutputModes", mode);
  append_general(pending_, stream.node, "xnMapOutputMode", mode);
  integer("xnPixelFormat", is_depth ? 4 : 1);
  integer("oniPixelFormat", static_cast<std::uint64_t>(format));
  append_general(pending_, stream.node, "xnFOV", field_of_view);
  integer("Cropping", 1);
  append_general(pending_, stream.node, "xnCropping", Bytes(12, 0));
  integer("Mirror", 1);
  integer("xnMirror", 0);
  if (is_depth) {
    const std::string note = to_json(content_.camera);
    append_general(pending_, stream.node, kCameraNoteProperty, Bytes(note.begin(), note.end()));
  }
}

Result<void> OniWriter::write_depth(std::chrono::microseconds timestamp, const DepthImage& depth) {
  const CameraModel& model = content_.camera.model;
  if (depth.width() != model.width || depth.height() != model.height) {
    return fail(ErrorCode::kInvalid, path_ + ": a depth picture does not have the recording's size");
  }
  const std::uint16_t largest = *std::max_element(depth.pixels().begin(), depth.pixels().end());
  if (largest > largest_depth(content_.camera.unit)) {
    return fail(ErrorCode::kInvalid,
                path_ + ": depth beyond 10 m does not fit into a recording in millimetres");
  }
  payload_.clear();
  if (content_.depth == DepthCoding::k16z) {
    if (auto coded = append_depth_16z(depth, payload_); !coded) return fail(coded.error());
  } else {
    for (const std::uint16_t value : depth.pixels()) append(payload_, value, 2);
  }
  return append_frame(depth_, timestamp, payload_);
}

Result<void> OniWriter::write_color(std::chrono::microseconds timestamp, const ColorImage& color) {
  assert(content_.color);
  const CameraModel& model = content_.camera.model;
  if (color.width() != model.width || color.height() != model.height) {
    return fail(ErrorCode::kInvalid, path_ + ": a colour picture does not have the recording's size");
  }
  const auto* first = reinterpret_cast<const std::uint8_t*>(color.data());
  const std::size_t size = color.pixels().size_bytes();
  if (content_.color == ColorCoding::kRaw) return append_frame(color_, timestamp, {first, size});

  payload_.clear();
  try {
    const cv::Mat rgb(color.height(), color.width(), CV_8UC3, const_cast<std::uint8_t*>(first));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    cv::imencode(".jpg", bgr, payload_, {cv::IMWRITE_JPEG_QUALITY, content_.jpeg_quality});
  } catch (const cv::Exception& failure) {
    return fail(ErrorCode::kUnsupported, path_ + ": a colour picture cannot be coded: " + failure.what());
  }
  return append_frame(color_, timestamp, payload_);
}

Result<void> OniWriter::write_jpeg(std::chrono::microseconds timestamp, std::span<const std::uint8_t> jpeg) {
  assert(content_.color == ColorCoding::kJpeg);
  return append_frame(color_, timestamp, jpeg);
}

Result<void> OniWriter::append_frame(Stream& stream, std::chrono::microseconds timestamp,
                                     std::span<const std::uint8_t> payload) {
  assert(file_);
  if (timestamp.count() < 0 || (!stream.frames.empty() && static_cast<std::uint64_t>(timestamp.count()) <
                                                              stream.frames.back().timestamp_us)) {
    return fail(ErrorCode::kInvalid, path_ + ": a frame lies before the one written before it");
  }
  const auto timestamp_us = static_cast<std::uint64_t>(timestamp.count());
  const std::uint64_t undo = stream.frames.empty() ? 0 : stream.frames.back().position;
  const std::uint64_t at = position_;
  Bytes fields;
  append_u64(fields, timestamp_us);
  append_u32(fields, stream.frames.size() + 1);
  append_record(pending_, RecordType::kNewData, stream.node, fields, payload.size(), undo);
  pending_.insert(pending_.end(), payload.begin(), payload.end());
  if (auto written = flush(); !written) return written;
  stream.frames.push_back({timestamp_us, at});
  return {};
}

Result<void> OniWriter::finish() {
  assert(file_);
  std::vector<const Stream*> streams{&depth_};
  if (content_.color) streams.push_back(&color_);
  std::vector<std::uint64_t> seek_tables;
  std::uint64_t largest_timestamp = 0;
  for (const Stream* stream : streams) {
    append_record(pending_, RecordType::kNodeRemoved, stream->node, {}, 0, stream->added_position);
    if (auto written = flush(); !written) return written;
    seek_tables.push_back(position_);
    append_record(pending_, RecordType::kSeekTable, stream->node, {},
                  (stream->frames.size() + 1) * kSeekEntryBytes);
    pending_.resize(pending_.size() + kSeekEntryBytes, 0);
    for (const Frame& frame : stream->frames) {
      append_u64(pending_, frame.timestamp_us);
      append_u32(pending_, 0);
      append_u64(pending_, frame.position);
      largest_timestamp = std::max(largest_timestamp, frame.timestamp_us);
    }
    if (auto written = flush(); !written) return written;
  }
  append_record(pending_, RecordType::kEnd, 0, {});
  if (auto written = flush(); !written) return written;

  // What only the end knows: the node records again, in place, and the header.
  const auto rewrite = [&](std::uint64_t at) -> Result<void> {
    if (std::fseek(file_.get(), static_cast<long>(at), SEEK_SET) != 0) return disk_error("finished");
    return flush();
  };
  for (std::size_t i = 0; i < streams.size(); ++i) {
    append_node(*streams[i], seek_tables[i]);
    if (auto written = rewrite(streams[i]->added_position); !written) return written;
  }
  pending_ = header(largest_timestamp, content_.color ? 2 : 1);
  if (auto written = rewrite(0); !written) return written;
  if (std::fclose(file_.release()) != 0) return disk_error("finished");
  return {};
}

Result<void> OniWriter::flush() {
  const bool whole = std::fwrite(pending_.data(), 1, pending_.size(), file_.get()) == pending_.size() &&
                     std::fflush(file_.get()) == 0;
  position_ += pending_.size();
  pending_.clear();
  if (!whole) return disk_error("written");
  return {};
}

tl::unexpected<Error> OniWriter::disk_error(const char* doing) const {
  return fail(ErrorCode::kUnavailable,
              path_ + ": the recording cannot be " + doing + ": " + std::strerror(errno));
}

}  // namespace copresence::recording
