#include "common/video/picture_encoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "common/video/libav.h"

namespace copresence::video {
namespace {

constexpr int kMaxQp = 63;          // at 10 bit
constexpr int kInfinite = 1 << 30;  // x264's own word for a group of pictures without end

void set(AVCodecContext& context, const char* key, const std::string& value) {
  [[maybe_unused]] const int code = av_opt_set(context.priv_data, key, value.c_str(), 0);
  assert(code >= 0);
}

void tell_rate(AVCodecContext& context, const PictureRate& rate) {
  context.bit_rate = std::llround(1000 * rate.kbps);
  context.rc_max_rate =
      context.bit_rate;  // both the same: x264 then holds every stretch to it, not only the mean
  context.rc_buffer_size = static_cast<int>(std::lround(1000 * rate.buffer_kbit));
}

// Both presets are measured on real recordings (docs/internals/video.md): where more time buys little.
constexpr const char* kDepthOptions =
    "scenecut=0"
    // Psychovisual tricks and adaptive quantisation move error to where eyes don't see it. Geometry has no
    // such place.
    ":psy=0:aq-mode=0"
    // Depth is smooth between sharp edges: 4x4 transforms follow them, 8x8 cost 6 % more; small partitions
    // save 12 % at the same error, a strong deblocking filter 4 to 8 % of the error; weighting looks for
    // fades.
    ":no-8x8dct=1:analyse=i4x4,p8x8,p4x4:deblock=2,2:weightp=0:subme=0"
    // Rounding closer to the nearest step instead of towards zero: a third fewer of the large errors at the
    // same rate.
    ":deadzone-inter=11:deadzone-intra=11";
constexpr const char* kColorOptions =
    "scenecut=0"
    // CABAC is worth 0.4 dB and costs both ends 0.4 ms; adaptive quantisation costs 1 dB.
    ":cabac=0:aq-mode=0"
    // Of the intra kinds 8x8 alone is as good; weighting looks for fades.
    ":analyse=i8x8:weightp=0";

// The same for machines that do much else: small partitions and CABAC are what time goes into.
constexpr const char* kLiveDepthOptions =
    "scenecut=0:psy=0:aq-mode=0:analyse=i4x4:deblock=2,2:no-deblock=0:deadzone-inter=11:deadzone-intra=11";
constexpr const char* kLiveColorOptions = "scenecut=0:aq-mode=0";

/// Whether the deblocking filter has anything to do: its threshold is 0 up to an index of 15 (H.264 table 8-16), which is
/// the quantiser as at 8 bit and twice the presets' 2. Without it the pictures are the same, and neither end goes through
/// all their edges for nothing.
bool can_deblock(const PictureSettings& settings) {
  constexpr int kFirstIndex = 16, kPresetOffset = 2 * 2, kTenBitOffset = 12;
  const int bits_offset = settings.format == PixelFormat::kGray10 ? kTenBitOffset : 0;
  return settings.rate || settings.qp - bits_offset + kPresetOffset >= kFirstIndex;
}

/// Processors of the first generation with AVX-512 (Skylake, Cascade Lake) run a core slower for a while after its widest
/// instructions, and everything else on that core pays: hole filling, decoding, rendering. x264 writes the same bits
/// without them; two live cameras then take 1 % less time in all (docs/internals/video.md).
bool slows_down_by_avx512() {
  const int flags = av_get_cpu_flags();
  return (flags & AV_CPU_FLAG_AVX512) != 0 && (flags & AV_CPU_FLAG_AVX512ICL) == 0;
}

void set_presets(AVCodecContext& context, const PictureSettings& settings) {
  const bool live = settings.preset == Preset::kLive;
  set(context, "preset", live ? "ultrafast" : "superfast");
  set(context, "tune", "zerolatency");
  set(context, "forced-idr", "1");
  std::string options;
  if (settings.kind == PictureKind::kDepth) {
    options = live ? kLiveDepthOptions : kDepthOptions;
    if (!can_deblock(settings)) options += ":no-deblock=1";
  } else {
    options = live ? kLiveColorOptions : kColorOptions;
    context.colorspace = AVCOL_SPC_SMPTE170M;  // the BT.601 matrix of common/color
    context.color_primaries = AVCOL_PRI_BT709;
    context.color_trc = AVCOL_TRC_IEC61966_2_1;
  }
  if (slows_down_by_avx512()) options += ":asm=AVX2";
  set(context, "x264-params", options);
  if (settings.rate) {
    tell_rate(context, *settings.rate);
    // Finer quantisers cost more than none at all and are not better by what a depth code is worth.
    if (settings.kind == PictureKind::kDepth) context.qmin = settings.format == PixelFormat::kGray10 ? 8 : 4;
  } else {
    set(context, "qp", std::to_string(settings.qp));
  }
}

/// The quantiser that libx264 says it used on the mean; 0 where it does not say, which costs the decoder's edge repair.
int qp_of(const AVPacket& packet) {
  std::size_t size = 0;
  const std::uint8_t* const stats = av_packet_get_side_data(&packet, AV_PKT_DATA_QUALITY_STATS, &size);
  std::int32_t lambda = 0;  // the first four bytes, little-endian
  for (std::size_t i = 0; stats && size >= 4 && i < 4; ++i) lambda |= stats[i] << (8 * i);
  return std::clamp(lambda / FF_QP2LAMBDA, 0, kMaxQp);
}

/// Lends a picture's planes to a frame without a copy: they are read until the frame is let go.
void lend(const Picture& picture, AVFrame& frame) {
  for (int plane = 0; plane < picture.planes(); ++plane) {
    const bool deep = picture.bytes_per_sample() == 2;
    const auto* first =
        deep ? reinterpret_cast<const std::uint8_t*>(picture.plane10().data()) : picture.plane8(plane).data();
    const std::size_t row_bytes =
        static_cast<std::size_t>(picture.plane_width(plane)) * picture.bytes_per_sample();
    auto* const bytes = const_cast<std::uint8_t*>(first);  // AV_BUFFER_FLAG_READONLY keeps the promise
    frame.buf[plane] = av_buffer_create(
        bytes, row_bytes * picture.plane_height(plane), [](void*, std::uint8_t*) {}, nullptr,
        AV_BUFFER_FLAG_READONLY);
    frame.data[plane] = bytes;
    frame.linesize[plane] = static_cast<int>(row_bytes);
  }
}

}  // namespace

Result<PictureEncoder> PictureEncoder::open(const PictureSettings& settings) {
  assert(settings.width > 0 && settings.width % 2 == 0 && settings.height > 0 && settings.height % 2 == 0);
  silence_libav();
  const AVCodec* const codec = avcodec_find_encoder_by_name("libx264");
  if (!codec)
    return fail(ErrorCode::kUnsupported, "this machine's libavcodec has no libx264: install libavcodec59");
  CodecContext context(avcodec_alloc_context3(codec));
  const auto rate = static_cast<int>(std::lround(settings.frames_per_second * 1000));
  context->width = settings.width;
  context->height = settings.height;
  context->time_base = {1000, rate};
  context->framerate = {rate, 1000};
  context->pix_fmt = to_libav(settings.format);
  context->color_range = AVCOL_RANGE_JPEG;
  context->gop_size = kInfinite;
  context->max_b_frames = 0;
  context->thread_count = 1;
  set_presets(*context, settings);
  if (const int code = avcodec_open2(context.get(), codec, nullptr); code < 0) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("libx264 cannot encode {}x{} {}: {}", settings.width, settings.height,
                            name(settings.format), libav_error(code)));
  }
  return PictureEncoder(settings, std::move(context), AvFrame(av_frame_alloc()), AvPacket(av_packet_alloc()));
}

PictureEncoder::PictureEncoder(const PictureSettings& settings, CodecContext context, AvFrame frame,
                               AvPacket packet)
    : settings_(settings),
      context_(std::move(context)),
      frame_(std::move(frame)),
      packet_(std::move(packet)) {}

Result<std::vector<std::uint8_t>> PictureEncoder::encode(const Picture& picture, bool keyframe) {
  assert(picture.format() == settings_.format && picture.width() == settings_.width &&
         picture.height() == settings_.height);
  frame_->format = context_->pix_fmt;
  frame_->width = settings_.width;
  frame_->height = settings_.height;
  frame_->color_range = context_->color_range;
  frame_->pict_type = keyframe || keyframe_needed_ ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
  frame_->pts = pictures_++;
  lend(picture, *frame_);
  int code = avcodec_send_frame(context_.get(), frame_.get());
  av_frame_unref(frame_.get());
  if (code >= 0) code = avcodec_receive_packet(context_.get(), packet_.get());
  keyframe_needed_ = code < 0;
  if (code < 0)
    return fail(ErrorCode::kUnsupported,
                fmt::format("libx264 did not encode a picture: {}", libav_error(code)));
  qp_ = qp_of(*packet_);
  std::vector<std::uint8_t> access_unit(packet_->data, packet_->data + packet_->size);
  av_packet_unref(packet_.get());
  return access_unit;
}

void PictureEncoder::set_rate(const PictureRate& rate) {
  assert(settings_.rate && rate.kbps > 0 && rate.buffer_kbit > 0);
  settings_.rate = rate;
  tell_rate(*context_, rate);  // libavcodec hands changes on with the next picture
}

}  // namespace copresence::video
