#include "capture_server/recording/stream_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "capture_server/recording/record_bytes.h"

namespace copresence::recording {
namespace {

using Kind = RecordedStream::Kind;

constexpr auto kDepthMillimetre = static_cast<std::uint64_t>(OniPixelFormat::kDepthMillimetre);
constexpr auto kDepth100Micrometres = static_cast<std::uint64_t>(OniPixelFormat::kDepth100Micrometres);
constexpr auto kRgb888 = static_cast<std::uint64_t>(OniPixelFormat::kRgb888);
constexpr auto kGray8 = static_cast<std::uint64_t>(OniPixelFormat::kGray8);

// The values of OpenNI 1's "xnPixelFormat" from 1 on, as OpenNI2 translates them: RGB24, YUV422,
// 8-bit and 16-bit grey, MJPEG.
constexpr std::uint64_t kFromOpenNi1[] = {kRgb888, 201, kGray8, 203, 204};

// The player's buffer for one decoded frame, in bytes.
constexpr std::uint64_t kMaxPlayerFrame = 1600 * 1200 * 3;

}  // namespace

bool is_sane(const RecordedStream::FieldOfView& view) {
  const auto sane = [](double angle) { return angle > 0.01 && angle < std::numbers::pi - 0.01; };
  return sane(view.horizontal) && sane(view.vertical);
}

std::string_view name(Kind kind) {
  switch (kind) {
    case Kind::kDepth:
      return "depth";
    case Kind::kColor:
      return "colour";
    case Kind::kInfrared:
      return "infrared";
  }
  return "";
}

bool StreamFormat::apply(Kind kind, RecordType type, std::string_view key,
                         std::span<const std::uint8_t> value) {
  FieldReader fields(value);
  const bool is_int = type == RecordType::kIntProperty;
  const bool is_general = type == RecordType::kGeneralProperty;

  if (is_general && key == "xnMapOutputMode") {
    width = fields.u32();
    height = fields.u32();
    frames_per_second = fields.u32();
    return fields.whole() && width <= 65535 && height <= 65535 && frames_per_second >= 1 &&
           frames_per_second <= 1000;
  }
  if (is_int && key == "xnPixelFormat") {
    const std::uint64_t number = fields.u64();
    if (kind == Kind::kDepth) {
      // The value does not matter, because a recorder of another format adds oniPixelFormat.
      pixel_format = kDepthMillimetre;
      return true;
    }
    if (number < 1 || number > std::size(kFromOpenNi1)) return false;
    pixel_format = kFromOpenNi1[number - 1];
    return true;
  }
  if (is_int && key == "oniPixelFormat") {
    pixel_format = fields.u64();
    return true;
  }
  if (is_int && (key == "oniRequiredFrameSize" || key == "RequiredDataSize")) {
    frame_buffer = fields.u64();
    return frame_buffer > 0 && frame_buffer <= 4 * kMaxPlayerFrame;
  }
  if (is_int && key == "xnDeviceMaxDepth") {
    const std::uint64_t max_depth = fields.u64();
    has_max_depth = true;
    return max_depth >= 1 && max_depth <= 65536;
  }
  if (is_general && key == "xnCropping") {
    cropped = fields.u32() != 0;
    has_cropping = true;
    fields.u64();  // Offset and size of the crop, four times 16 bits.
    return fields.whole();
  }
  if (is_general && key == "xnFOV") {
    const double horizontal = fields.f64();
    field_of_view = {horizontal, fields.f64()};
    return fields.whole() && is_sane(*field_of_view);
  }
  if (is_general && key == "xnRealWorldTranslationData") {
    // Early versions of OpenNI 1 state the field of view by three numbers: the distance of a plane,
    // the size of a pixel in it, and the ratio of source to depth pixels.
    const double distance = fields.f64(), pixel = fields.f64(), ratio = fields.f64();
    const auto angle = [&](std::uint32_t size) { return 2 * std::atan(pixel * ratio * size / 2 / distance); };
    field_of_view = {angle(width), angle(height)};
    return fields.whole() && is_sane(*field_of_view);
  }
  // The player looks only at these keys, so it would misread a property of another type.
  constexpr std::string_view kKnown[] = {"xnMapOutputMode",      "xnPixelFormat", "oniPixelFormat",
                                         "oniRequiredFrameSize", "xnCropping",    "xnFOV",
                                         "xnDeviceMaxDepth"};
  return std::find(std::begin(kKnown), std::end(kKnown), key) == std::end(kKnown);
}

std::uint64_t StreamFormat::bytes_per_pixel(Kind kind) const {
  if (kind == Kind::kColor || (kind == Kind::kInfrared && pixel_format == kRgb888)) return 3;
  return kind == Kind::kInfrared && pixel_format == kGray8 ? 1 : 2;
}

Result<void> StreamFormat::describe(RecordedStream& stream) const {
  const auto corrupt = [&](const std::string& what) {
    return fail(ErrorCode::kCorrupt, fmt::format("stream {} {}", stream.name, what));
  };
  const auto unsupported = [&](const std::string& what) {
    return fail(ErrorCode::kUnsupported, fmt::format("stream {} {}", stream.name, what));
  };
  if (width == 0 || height == 0) return corrupt("has no size");
  if (width % 2 || height % 2 || width > 4096 || height > 4096) {
    return unsupported(fmt::format(
        "is {}x{} pixels, only even sizes up to 4096 can be used; use another mode or scale the images",
        width, height));
  }
  const std::uint64_t format = pixel_format                  ? pixel_format
                               : stream.kind == Kind::kDepth ? kDepthMillimetre
                                                             : kRgb888;
  if (stream.kind == Kind::kDepth && format != kDepthMillimetre && format != kDepth100Micrometres) {
    return unsupported(
        fmt::format("has pixel format {}, only depth in 1 mm ({}) or 0.1 mm ({}) can be used; record such",
                    format, kDepthMillimetre, kDepth100Micrometres));
  }
  if (stream.kind == Kind::kColor && format != kRgb888) {
    return unsupported(
        fmt::format("has pixel format {}, only RGB888 ({}) can be used; record such", format, kRgb888));
  }
  const std::uint64_t frame_bytes = std::uint64_t{width} * height * bytes_per_pixel(stream.kind);
  if (frame_bytes > kMaxPlayerFrame) {
    return unsupported(
        fmt::format("is {}x{} pixels, more than OpenNI2 can play ({} bytes a frame, {} are too many); use a "
                    "smaller mode or scale "
                    "the images down",
                    width, height, kMaxPlayerFrame, frame_bytes));
  }
  if (frame_buffer && frame_buffer < frame_bytes) {
    return corrupt(fmt::format("claims frames of {} bytes, they take {}", frame_buffer, frame_bytes));
  }
  if (!has_cropping && stream.kind != Kind::kInfrared) {
    return unsupported("has no property xnCropping, without which OpenNI2 plays nothing; record it again");
  }
  if (cropped) return unsupported("was recorded cropped; record it without cropping");
  // The player has no decoder for the frames in any of the following cases.
  const bool depth_codec = stream.codec == "16zT" || stream.codec == "16zP";
  const bool fits = stream.codec == "NONE" ||
                    (stream.kind == Kind::kColor ? stream.codec == "JPEG" : depth_codec) ||
                    (stream.kind == Kind::kInfrared && stream.codec == "Im8z");
  if (!fits) return corrupt(fmt::format("has a codec that is none for {}", recording::name(stream.kind)));
  if (stream.codec == "16zT" && !has_max_depth)
    return corrupt("has no xnDeviceMaxDepth, which its codec needs");

  stream.width = static_cast<int>(width);
  stream.height = static_cast<int>(height);
  stream.frames_per_second = static_cast<int>(frames_per_second);
  stream.unit = format == kDepth100Micrometres ? DepthUnit::k100Micrometres : DepthUnit::kMillimetre;
  stream.field_of_view = field_of_view;
  return {};
}

// A frame larger than its codec can produce is a broken record. This limit also keeps OpenNI2's
// reads beyond a damaged payload inside its own buffer, which is much larger.
std::uint64_t StreamFormat::max_payload(std::string_view codec, Kind kind) const {
  const std::uint64_t pixels = std::uint64_t{width} * height;
  const std::uint64_t frame_bytes = pixels * bytes_per_pixel(kind);
  // Largest size: an escape and two bytes per pixel, the table, and two numbers.
  if (codec == "16zT") return 3 * pixels + 2 * 65536 + 4;
  if (codec == "16zP") return 3 * pixels + 2;
  if (codec == "Im8z") return 2 * pixels + 2;
  if (codec == "JPEG") return 2 * frame_bytes + 65536;
  return frame_bytes;
}

}  // namespace copresence::recording
