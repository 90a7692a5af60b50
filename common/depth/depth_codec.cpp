#include "common/depth/depth_codec.h"

#include <string>
#include <vector>

#include "common/depth/codec_catalogue.h"
#include "common/depth/completion.h"
#include "common/depth/edge_repair.h"
#include "common/depth/plane_codec.h"
#include "common/depth/side_data_seal.h"
#include "common/depth/state_mask.h"

namespace copresence::depth {

namespace {

// The first byte before a state mask: whether the decoder gets the picture's samples as they were, or repairs edges.
constexpr std::uint8_t kLossless = 0, kLossy = 1;

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
  Parts(std::unique_ptr<PlaneEncoder> planes_, const DepthFormat& format)
      : planes(std::move(planes_)),
        description(planes->description()),
        completion(format.width, format.height, format.units(), format.unit),
        mask(format.width, format.height) {}

  std::unique_ptr<PlaneEncoder> planes;
  DepthCodecDescription description;
  Completion completion;
  StateMaskEncoder mask;
  SideDataSeal seal;
  std::uint8_t coding = kLossy;
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

void Encoder::set_lossless(bool lossless) {
  parts_->coding = lossless ? kLossless : kLossy;
  parts_->planes->set_lossless(lossless);
}

Result<PlanarDepth> Encoder::encode(const DepthImage& depth, const StateImage& states, bool keyframe) {
  Parts& parts = *parts_;
  parts.completion.take(depth, states);
  PlanarDepth out;
  out.keyframe = keyframe || parts.keyframe_due;
  parts.keyframe_due = true;  // until this frame is done
  const auto encoded = parts.planes->encode(parts.completion.depth(), parts.completion.states(), out);
  if (!encoded) return fail(encoded.error());
  out.state_mask.push_back(parts.coding);
  parts.mask.encode(parts.completion.states(), out.keyframe, out.state_mask);
  parts.seal.close(out.keyframe, out.table, out.state_mask);
  parts.keyframe_due = false;
  return out;
}

struct Decoder::Parts {
  Parts(std::unique_ptr<PlaneDecoder> planes_, const DepthFormat& format_, PixelFormat picture_)
      : planes(std::move(planes_)),
        format(format_),
        picture(picture_),
        mask(format.width, format.height),
        repair(format.unit) {}

  std::unique_ptr<PlaneDecoder> planes;
  DepthFormat format;
  PixelFormat picture;
  StateMaskDecoder mask;
  EdgeRepair repair;
  SideDataSeal seal;
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
  const Picture& picture = planes.picture;
  if (picture.format() != parts.picture || picture.width() != parts.format.width ||
      picture.height() != parts.format.height) {
    parts.seal.break_chain();
    return fail(ErrorCode::kCorrupt, "a depth picture does not have the format of its stream");
  }
  const auto mask = parts.seal.open(planes.keyframe, planes.table, planes.state_mask);
  if (!mask) {
    return fail(ErrorCode::kCorrupt,
                "state mask or level table are damaged, or a frame is missing before them");
  }
  const std::uint8_t coding = mask->empty() ? std::uint8_t{255} : mask->front();
  if (coding != kLossless && coding != kLossy) {
    parts.seal.break_chain();
    return fail(ErrorCode::kCorrupt, "a state mask does not say how its picture is coded");
  }
  parts.mask.decode(mask->subspan(1), planes.keyframe, states);
  depth.resize(parts.format.width, parts.format.height);
  if (const auto decoded = parts.planes->decode(planes, states, depth); !decoded) {
    parts.seal.break_chain();
    return fail(decoded.error());
  }
  if (coding == kLossy) parts.repair.repair(depth);
  std::uint16_t* const z = depth.data();
  const DepthState* const state = states.data();
  const std::size_t size = depth.pixels().size();
  for (std::size_t i = 0; i < size; ++i) z[i] = state[i] == DepthState::kHole ? std::uint16_t{0} : z[i];
  return {};
}

}  // namespace copresence::depth
