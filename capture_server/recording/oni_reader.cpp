#include "capture_server/recording/oni_reader.h"

#include <fmt/format.h>

#include <cassert>
#include <cstring>

#include "capture_server/recording/depth_16z.h"
#include "capture_server/recording/jpeg.h"
#include "capture_server/recording/oni_parser.h"

namespace copresence::recording {
namespace {

tl::unexpected<Error> damaged(const RecordedStream& stream, std::size_t frame) {
  return fail(ErrorCode::kCorrupt, fmt::format("frame {} of stream {} is damaged", frame + 1, stream.name));
}

}  // namespace

Result<OniReader> OniReader::open(const std::string& path) {
  auto file = file::InputFile::open(path, "an .oni recording");
  if (!file) return fail(file.error());
  RecordBytes bytes(*file);
  auto summary = OniParser(bytes, path).run();
  if (!summary) return fail(summary.error());
  return OniReader(std::move(*file), std::move(*summary));
}

Result<std::vector<std::uint8_t>> OniReader::payload(const RecordedStream& stream, std::size_t frame) const {
  assert(frame < stream.payloads.size());
  std::vector<std::uint8_t> bytes(stream.payloads[frame].bytes);
  if (!file_.read(stream.payloads[frame].position, bytes)) return damaged(stream, frame);
  return bytes;
}

Result<DepthImage> OniReader::depth(std::size_t frame) const {
  const RecordedStream& stream = *summary_.find(RecordedStream::Kind::kDepth);
  const auto bytes = payload(stream, frame);
  if (!bytes) return fail(bytes.error());
  DepthImage image;
  image.resize(stream.width, stream.height);
  if (stream.codec == "NONE") {
    if (bytes->size() != image.pixels().size_bytes()) return damaged(stream, frame);
    std::memcpy(image.data(), bytes->data(), bytes->size());
    return image;
  }
  const DepthTable table = stream.codec == "16zT" ? DepthTable::kEmbedded : DepthTable::kNone;
  if (!expand_depth_16z(*bytes, table, image)) return damaged(stream, frame);
  return image;
}

Result<ColorImage> OniReader::color(std::size_t frame) const {
  const RecordedStream& stream = *summary_.find(RecordedStream::Kind::kColor);
  const auto bytes = payload(stream, frame);
  if (!bytes) return fail(bytes.error());
  ColorImage image;
  image.resize(stream.width, stream.height);
  if (stream.codec == "NONE") {
    if (bytes->size() != image.pixels().size_bytes()) return damaged(stream, frame);
    std::memcpy(image.data(), bytes->data(), bytes->size());
    return image;
  }
  if (!decode_jpeg(*bytes, image)) return damaged(stream, frame);
  return image;
}

}  // namespace copresence::recording
