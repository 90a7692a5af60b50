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

constexpr int kMaxQp = 63;          // At 10 bits.
constexpr int kInfinite = 1 << 30;  // In x264 this value means an unlimited group of pictures.

void set(AVCodecContext& context, const char* key, const std::string& value) {
  [[maybe_unused]] const int code = av_opt_set(context.priv_data, key, value.c_str(), 0);
  assert(code >= 0);
}

void apply_rate(AVCodecContext& context, const PictureRate& rate) {
  context.bit_rate = std::llround(1000 * rate.kbps);
  // With equal mean and maximum, x264 keeps every sequence of pictures to the rate.
  context.rc_max_rate = context.bit_rate;
  context.rc_buffer_size = static_cast<int>(std::lround(1000 * rate.buffer_kbit));
}

// Both presets were chosen by measurements on real recordings (docs/internals/video.md).
constexpr const char* kDepthOptions =
    "scenecut=0"
    // Psychovisual optimisation and adaptive quantisation move error to where eyes do not see it.
    // In depth, error is visible everywhere.
    ":psy=0:aq-mode=0"
    // Depth is smooth between sharp edges. 4x4 transforms follow these edges; 8x8 transforms cost 6
    // % more bits. Small partitions save 12 % of the bits at the same error. A strong deblocking
    // filter reduces the error by 4 to 8 %. Depth has no fades, so weighted prediction is off.
    ":no-8x8dct=1:analyse=i4x4,p8x8,p4x4:deblock=2,2:weightp=0:subme=0"
    // Rounding less towards zero gives a third fewer large errors at the same rate.
    ":deadzone-inter=11:deadzone-intra=11";
constexpr const char* kColorOptions =
    "scenecut=0"
    // CABAC would gain 0.4 dB but cost 0.4 ms at both ends. Adaptive quantisation would lose 1 dB.
    ":cabac=0:aq-mode=0"
    // Of the intra modes, 8x8 alone is as good as all modes together. Weighted prediction is for
    // fades.
    ":analyse=i8x8:weightp=0";

// Options for little free CPU time. Small partitions and CABAC take most time, so they are off.
constexpr const char* kLiveDepthOptions =
    "scenecut=0:psy=0:aq-mode=0:analyse=i4x4:deblock=2,2:no-deblock=0:deadzone-inter=11:deadzone-intra=11";
constexpr const char* kLiveColorOptions = "scenecut=0:aq-mode=0";

/// True if the deblocking filter can change a sample. The filter's threshold is 0 up to an index of
/// 15 (H.264 table 8-16). The index is the QP on the scale of 8 bits, plus twice the presets'
/// offset of 2. Otherwise the filter is switched off, which saves time and gives the same pictures.
bool can_deblock(const PictureSettings& settings) {
  constexpr int kFirstIndex = 16, kPresetOffset = 2 * 2, kTenBitOffset = 12;
  const int bits_offset = settings.format == PixelFormat::kGray10 ? kTenBitOffset : 0;
  return settings.rate || settings.qp - bits_offset + kPresetOffset >= kFirstIndex;
}

/// True for the first processors with AVX-512 (Skylake, Cascade Lake). Such processors lower a
/// core's clock for a while after their widest instructions. A lower clock slows down everything
/// else on that core: hole filling, decoding, rendering. Without these instructions x264 writes the
/// same bits, and two live cameras take 1 % less time in all (docs/internals/video.md).
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
    context.colorspace = AVCOL_SPC_SMPTE170M;  // The BT.601 matrix of common/color.
    context.color_primaries = AVCOL_PRI_BT709;
    context.color_trc = AVCOL_TRC_IEC61966_2_1;
  }
  if (slows_down_by_avx512()) options += ":asm=AVX2";
  set(context, "x264-params", options);
  if (settings.rate) {
    apply_rate(context, *settings.rate);
    // Lower QPs cost more bits than lossless coding and gain less than one depth code.
    if (settings.kind == PictureKind::kDepth) context.qmin = settings.format == PixelFormat::kGray10 ? 8 : 4;
  } else {
    set(context, "qp", std::to_string(settings.qp));
  }
}

/// Returns the mean QP from libx264, or 0 if unknown. With 0 the receiver repairs no edges.
int qp_of(const AVPacket& packet) {
  std::size_t size = 0;
  const std::uint8_t* const stats = av_packet_get_side_data(&packet, AV_PKT_DATA_QUALITY_STATS, &size);
  std::int32_t lambda = 0;  // Lambda is in the first four bytes, little-endian.
  for (std::size_t i = 0; stats && size >= 4 && i < 4; ++i) lambda |= stats[i] << (8 * i);
  return std::clamp(lambda / FF_QP2LAMBDA, 0, kMaxQp);
}

/// Makes a frame refer to a picture's planes. The picture must outlive the frame's use.
void refer_to(const Picture& picture, AVFrame& frame) {
  for (int plane = 0; plane < picture.planes(); ++plane) {
    const bool deep = picture.bytes_per_sample() == 2;
    const auto* first =
        deep ? reinterpret_cast<const std::uint8_t*>(picture.plane10().data()) : picture.plane8(plane).data();
    const std::size_t row_bytes =
        static_cast<std::size_t>(picture.plane_width(plane)) * picture.bytes_per_sample();
    // AV_BUFFER_FLAG_READONLY prevents writing.
    auto* const bytes = const_cast<std::uint8_t*>(first);
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
  refer_to(picture, *frame_);
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
  apply_rate(*context_, rate);  // libavcodec applies changes with the next picture.
}

}  // namespace copresence::video
