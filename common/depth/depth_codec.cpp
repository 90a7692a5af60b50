#include "common/depth/depth_codec.h"

#include <optional>
#include <string>
#include <vector>

#include "common/depth/background_fill.h"
#include "common/depth/codec_catalogue.h"
#include "common/depth/edge_repair.h"
#include "common/depth/entropy/residual_coder.h"
#include "common/depth/levels/chained_checksum.h"
#include "common/depth/mask/validity_mask.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

namespace {

// The byte before a state mask: how the picture comes.
constexpr std::uint8_t kThroughVideo = 0, kAsSamples = 1;

// From this quantiser of 8 bits on video coding blurs edges more often than a true point lies between two surfaces: it is where
// H.264's deblocking begins to act.
constexpr int kRepairFrom = 12;
constexpr int kTenBits = 12;  // quantisers as coarse are higher by this at 10 bit

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
        completion(format.width, format.height, format.units(), format.unit, format.noise),
        mask(format.width, format.height) {}

  std::unique_ptr<PlaneEncoder> planes;
  DepthCodecDescription description;
  DepthFormat format;
  BackgroundFill completion;
  ValidityMaskEncoder mask;
  std::optional<ResidualEncoder> residuals;  // where pictures are coded without loss and monochrome
  ChainedChecksum seal;
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
  parts.coding = exact ? kAsSamples : kThroughVideo;
  parts.planes->set_lossless(lossless);
  parts.keyframe_due = true;
  parts.residuals.reset();
  if (exact) parts.residuals.emplace(parts.description.format, parts.format.width, parts.format.height);
}

Result<PlanarDepth> Encoder::encode(const DepthImage& depth, const StateImage& states, bool keyframe) {
  Parts& parts = *parts_;
  parts.completion.take(depth, states);
  PlanarDepth out;
  out.keyframe = keyframe || parts.keyframe_due;
  parts.keyframe_due = true;  // until this frame is done
  const auto encoded = parts.planes->encode(parts.completion.depth(), parts.completion.states(), out);
  if (!encoded) return fail(encoded.error());
  out.validity_mask.push_back(parts.coding);
  parts.mask.encode(parts.completion.states(), out.keyframe, out.validity_mask);
  if (parts.residuals) {
    parts.residuals->encode(out.picture, parts.completion.states(), out.keyframe, out.residuals);
    out.picture = Picture();
  }
  parts.seal.close(out.keyframe, out.table, out.residuals, out.validity_mask);
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

  bool is_ours(const Picture& other) const {
    return other.format() == picture && other.width() == format.width && other.height() == format.height;
  }

  std::unique_ptr<PlaneDecoder> planes;
  DepthFormat format;
  PixelFormat picture;
  ValidityMaskDecoder mask;
  ResidualDecoder residuals;
  PlanarDepth exact;  // a frame whose picture came as samples, since the last keyframe
  EdgeRepair repair;
  int repair_from;  // quantiser
  ChainedChecksum seal;
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
  const auto damaged = [&](const char* why) {
    parts.seal.break_chain();
    return fail(ErrorCode::kCorrupt, why);
  };
  const auto mask = parts.seal.open(planes.keyframe, planes.table, planes.residuals, planes.validity_mask);
  if (!mask)
    return damaged("state mask, level table or samples are damaged, or a frame is missing before them");
  const std::uint8_t coding = mask->empty() ? std::uint8_t{255} : mask->front();
  const bool exact = coding == kAsSamples;
  if (coding > kAsSamples || exact == planes.residuals.empty() || (exact && !is_monochrome(parts.picture))) {
    return damaged("a state mask does not say how its picture is coded");
  }
  if (!exact && !parts.is_ours(planes.picture)) {
    return damaged("a depth picture does not have the format of its stream");
  }
  parts.mask.decode(mask->subspan(1), planes.keyframe, states);
  if (exact) {
    if (!planes.keyframe && parts.exact.picture.empty())
      return damaged("samples build on frames that had none");
    parts.exact.keyframe = planes.keyframe;
    parts.exact.table = planes.table;
    parts.residuals.decode(planes.residuals, states, planes.keyframe, parts.exact.picture);
  } else {
    parts.exact.picture = Picture();
  }
  depth.resize(parts.format.width, parts.format.height);
  if (const auto decoded = parts.planes->decode(exact ? parts.exact : planes, states, depth); !decoded) {
    parts.seal.break_chain();
    return fail(decoded.error());
  }
  if (planes.qp >= parts.repair_from) parts.repair.repair(depth);
  std::uint16_t* const z = depth.data();
  const DepthState* const state = states.data();
  const std::size_t size = depth.pixels().size();
  for (std::size_t i = 0; i < size; ++i) z[i] = state[i] == DepthState::kHole ? std::uint16_t{0} : z[i];
  return {};
}

}  // namespace copresence::depth
