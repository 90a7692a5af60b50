#include "common/depth/depth_codec.h"

#include <cassert>
#include <optional>
#include <string>
#include <vector>

#include "common/depth/background_fill.h"
#include "common/depth/codec_catalogue.h"
#include "common/depth/edge_repair.h"
#include "common/depth/entropy/residual_coder.h"
#include "common/depth/mask/validity_mask.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

namespace {

// Values of the byte that precedes a validity mask and states how the picture is coded.
constexpr std::uint8_t kThroughVideo = 0, kAsResiduals = 1;

// Lowest QP at 8 bits at which edges are repaired. H.264's deblocking begins to act at this QP. At
// lower QPs, a point that really lies between two surfaces is more frequent than a blurred edge.
constexpr int kRepairFrom = 12;
constexpr int kTenBits = 12;  // At 10 bits, an equally coarse QP is higher by 12.

bool is_monochrome(PixelFormat format) {
  return format == PixelFormat::kGray8 || format == PixelFormat::kGray10;
}

}  // namespace

std::span<const std::string_view> codec_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> list;
    for (const CodecEntry& entry : codec_catalogue()) list.push_back(entry.name);
    return list;
  }();
  return names;
}

struct Encoder::Parts {
  Parts(std::unique_ptr<PlaneEncoder> planes_, const DepthFormat& format_)
      : planes(std::move(planes_)),
        description(planes->description()),
        format(format_),
        background(format.width, format.height, format.units(), format.unit, format.noise),
        mask(format.width, format.height) {}

  std::unique_ptr<PlaneEncoder> planes;
  DepthCodecDescription description;
  DepthFormat format;
  BackgroundFill background;
  ValidityMaskEncoder mask;
  std::optional<ResidualEncoder> residuals;  // Used if monochrome pictures are coded losslessly.
  std::uint8_t coding = kThroughVideo;
  bool lossless = false;
  bool keyframe_due = true;
};

Encoder::Encoder(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Encoder::~Encoder() = default;
Encoder::Encoder(Encoder&&) noexcept = default;
Encoder& Encoder::operator=(Encoder&&) noexcept = default;

Result<Encoder> Encoder::open(std::string_view codec_name, const DepthFormat& format) {
  if (const auto checked = check(format); !checked) return fail(checked.error());
  auto planes = make_encoder(codec_name, format);
  if (!planes) return fail(planes.error());
  return Encoder(std::make_unique<Parts>(std::move(*planes), format));
}

const DepthCodecDescription& Encoder::description() const {
  return parts_->description;
}

void Encoder::set_sensor_levels(std::span<const std::uint16_t> levels) {
  parts_->planes->set_sensor_levels(levels);
}

void Encoder::set_lossless(bool lossless) {
  Parts& parts = *parts_;
  if (lossless == parts.lossless) return;
  const bool exact = lossless && is_monochrome(parts.description.format);
  parts.lossless = lossless;
  parts.coding = exact ? kAsResiduals : kThroughVideo;
  parts.planes->set_lossless(lossless);
  parts.keyframe_due = true;
  parts.residuals.reset();
  if (exact) parts.residuals.emplace(parts.description.format, parts.format.width, parts.format.height);
}

void Encoder::set_bitrate(std::optional<int> kbps, double frames_per_second) {
  assert(frames_per_second > 0);
  parts_->planes->set_bits_per_frame(kbps ? std::optional(1000.0 * *kbps / frames_per_second) : std::nullopt);
}

Result<PlanarDepth> Encoder::encode(const DepthImage& depth, const StateImage& states, bool keyframe) {
  Parts& parts = *parts_;
  parts.background.take(depth, states);
  PlanarDepth out;
  out.keyframe = keyframe || parts.keyframe_due;
  parts.keyframe_due = true;  // The flag stays set if this frame fails.
  const auto encoded = parts.planes->encode(parts.background.depth(), parts.background.states(), out);
  if (!encoded) return fail(encoded.error());
  out.validity_mask.push_back(parts.coding);
  parts.mask.encode(parts.background.states(), out.keyframe, out.validity_mask);
  if (parts.residuals) {
    parts.residuals->encode(out.picture, parts.background.states(), out.keyframe, out.residuals);
    out.picture = Picture();
  }
  parts.keyframe_due = false;
  return out;
}

struct Decoder::Parts {
  Parts(std::unique_ptr<PlaneDecoder> planes_, const DepthFormat& format_, PixelFormat picture_)
      : planes(std::move(planes_)),
        format(format_),
        picture(picture_),
        mask(format.width, format.height),
        residuals(is_monochrome(picture) ? picture : PixelFormat::kGray8, format.width, format.height),
        repair(format.unit, format.noise),
        repair_from(picture == PixelFormat::kGray10 ? kRepairFrom + kTenBits : kRepairFrom) {}

  bool has_format_of(const Picture& other) const {
    return other.format() == picture && other.width() == format.width && other.height() == format.height;
  }

  std::unique_ptr<PlaneDecoder> planes;
  DepthFormat format;
  PixelFormat picture;
  ValidityMaskDecoder mask;
  ResidualDecoder residuals;
  PlanarDepth exact;  // Last frame with residuals; the picture is empty after other frames.
  EdgeRepair repair;
  int repair_from;  // Lowest QP at which edges are repaired.
  bool keyframe_needed = true;
};

Decoder::Decoder(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Decoder::~Decoder() = default;
Decoder::Decoder(Decoder&&) noexcept = default;
Decoder& Decoder::operator=(Decoder&&) noexcept = default;

Result<Decoder> Decoder::open(const DepthCodecDescription& description, const DepthFormat& format) {
  if (const auto checked = check(format); !checked) return fail(checked.error());
  const auto codec = find_codec(description.name);
  if (!codec) return fail(codec.error());
  auto planes = (*codec)->make_decoder(description, format);
  if (!planes) return fail(planes.error());
  const PixelFormat picture = (*codec)->picture;
  if (description.format != picture) {
    return fail(ErrorCode::kInvalid, "depth codec " + description.name + ": its pictures are " +
                                         std::string(name(picture)) + ", not " +
                                         std::string(name(description.format)));
  }
  return Decoder(std::make_unique<Parts>(std::move(*planes), format, description.format));
}

Result<void> Decoder::decode(const PlanarDepth& planes, DepthImage& depth, StateImage& states) {
  Parts& parts = *parts_;
  if (parts.keyframe_needed && !planes.keyframe)
    return fail(ErrorCode::kCorrupt, "depth builds on a frame that did not decode: a keyframe is needed");
  parts.keyframe_needed = true;  // The flag stays set if this frame fails.
  const std::span<const std::uint8_t> mask = planes.validity_mask;
  const std::uint8_t coding = mask.empty() ? std::uint8_t{255} : mask.front();
  const bool exact = coding == kAsResiduals;
  if (coding > kAsResiduals || exact == planes.residuals.empty() || (exact && !is_monochrome(parts.picture)))
    return fail(ErrorCode::kCorrupt, "a validity mask does not say how its picture is coded");
  if (!exact && !parts.has_format_of(planes.picture))
    return fail(ErrorCode::kCorrupt, "a depth picture does not have the format of its stream");
  parts.mask.decode(mask.subspan(1), planes.keyframe, states);
  if (exact) {
    if (!planes.keyframe && parts.exact.picture.empty())
      return fail(ErrorCode::kCorrupt, "residuals depend on an earlier frame without residuals");
    parts.exact.keyframe = planes.keyframe;
    parts.exact.table = planes.table;
    parts.residuals.decode(planes.residuals, states, planes.keyframe, parts.exact.picture);
  } else {
    parts.exact.picture = Picture();
  }
  depth.resize(parts.format.width, parts.format.height);
  if (const auto decoded = parts.planes->decode(exact ? parts.exact : planes, states, depth); !decoded)
    return fail(decoded.error());
  if (planes.qp >= parts.repair_from) parts.repair.repair(depth);
  std::uint16_t* const z = depth.data();
  const DepthState* const state = states.data();
  const std::size_t size = depth.pixels().size();
  for (std::size_t i = 0; i < size; ++i) z[i] = state[i] == DepthState::kHole ? std::uint16_t{0} : z[i];
  parts.keyframe_needed = false;
  return {};
}

}  // namespace copresence::depth
