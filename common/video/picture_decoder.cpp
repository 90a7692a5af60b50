#include "common/video/picture_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "common/bitstream/access_unit.h"
#include "common/video/libav.h"

namespace copresence::video {
namespace {

/// True if the frame's planes hold `format`. Depending on its version, FFmpeg decodes 4:0:0 as grey
/// or adds chroma planes of mid grey.
bool holds(AVPixelFormat decoded, PixelFormat format) {
  switch (format) {
    case PixelFormat::kGray8:
      return decoded == AV_PIX_FMT_GRAY8 || decoded == AV_PIX_FMT_YUV420P || decoded == AV_PIX_FMT_YUVJ420P;
    case PixelFormat::kGray10:
      return decoded == AV_PIX_FMT_GRAY10 || decoded == AV_PIX_FMT_YUV420P10;
    case PixelFormat::kYuv420:
      return decoded == AV_PIX_FMT_YUV420P || decoded == AV_PIX_FMT_YUVJ420P;
    case PixelFormat::kYuv444:
      return decoded == AV_PIX_FMT_YUV444P || decoded == AV_PIX_FMT_YUVJ444P;
  }
  return false;
}

/// Returns the frame's picture and empties the frame. If rows have no padding, the picture borrows
/// the decoder's planes. There is no padding if the width of every plane is a multiple of 64 bytes.
/// Borrowing is safe since the decoder only reads returned planes. Otherwise the planes are copied.
Picture take_picture(AVFrame& frame, PixelFormat format, int width, int height) {
  const std::shared_ptr<AVFrame> taken(av_frame_alloc(), AvFrameDeleter());
  av_frame_move_ref(taken.get(), &frame);
  Picture borrowed =
      Picture::borrowed(format, width, height, {taken->data[0], taken->data[1], taken->data[2]}, taken);
  const auto row_bytes = [&](int plane) { return borrowed.plane_width(plane) * borrowed.bytes_per_sample(); };
  bool is_padded = false;
  for (int i = 0; i < borrowed.planes(); ++i) is_padded = is_padded || taken->linesize[i] != row_bytes(i);
  if (!is_padded) return borrowed;

  Picture copy = Picture::uninitialised(format, width, height);
  for (int i = 0; i < copy.planes(); ++i) {
    auto* to = copy.bytes_per_sample() == 2 ? reinterpret_cast<std::uint8_t*>(copy.plane10().data())
                                            : copy.plane8(i).data();
    const std::uint8_t* from = taken->data[i];
    for (int y = 0; y < copy.plane_height(i); ++y, to += row_bytes(i), from += taken->linesize[i])
      std::memcpy(to, from, row_bytes(i));
  }
  return copy;
}

}  // namespace

Result<PictureDecoder> PictureDecoder::open(PixelFormat format, int width, int height) {
  silence_libav();
  const AVCodec* const codec = avcodec_find_decoder(AV_CODEC_ID_H264);
  if (!codec) return fail(ErrorCode::kUnsupported, "this machine's libavcodec has no H.264 decoder");
  CodecContext context(avcodec_alloc_context3(codec));
  context->thread_count = 1;
  context->flags |= AV_CODEC_FLAG_LOW_DELAY;
  context->err_recognition = AV_EF_CAREFUL | AV_EF_COMPLIANT | AV_EF_EXPLODE;
  context->error_concealment = 0;
  // Rejects huge sizes before memory is allocated. Sizes are rounded up to macroblocks.
  context->max_pixels = std::int64_t{width + 32} * (height + 32);
  if (const int code = avcodec_open2(context.get(), codec, nullptr); code < 0) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("the H.264 decoder does not open: {}", libav_error(code)));
  }
  return PictureDecoder(format, width, height, std::move(context), AvFrame(av_frame_alloc()),
                        AvPacket(av_packet_alloc()));
}

PictureDecoder::PictureDecoder(PixelFormat format, int width, int height, CodecContext context, AvFrame frame,
                               AvPacket packet)
    : format_(format),
      width_(width),
      height_(height),
      context_(std::move(context)),
      frame_(std::move(frame)),
      packet_(std::move(packet)) {}

void PictureDecoder::reset() {
  avcodec_flush_buffers(context_.get());
  keyframe_needed_ = true;
}

Result<Picture> PictureDecoder::decode(std::span<const std::uint8_t> access_unit) {
  auto picture = decode_checked(access_unit);
  if (!picture) reset();
  return picture;
}

Result<Picture> PictureDecoder::decode_checked(std::span<const std::uint8_t> access_unit) {
  const auto nals = bitstream::split_access_unit(access_unit);
  if (!nals) return fail(nals.error());
  bool keyframe = false;
  padded_.clear();
  for (const bitstream::Nal& nal : *nals) {
    if (!nal.is_essential()) continue;
    keyframe = keyframe || nal.type() == bitstream::NalType::kIdrSlice;
    bitstream::append_nal(padded_, nal.bytes);
  }
  if (keyframe_needed_ && !keyframe) {
    return fail(ErrorCode::kCorrupt, "a picture builds on pictures that were lost: a keyframe is needed");
  }
  const std::size_t size = padded_.size();
  padded_.resize(size + AV_INPUT_BUFFER_PADDING_SIZE, 0);
  packet_->data = padded_.data();
  packet_->size = static_cast<int>(size);
  int code = avcodec_send_packet(context_.get(), packet_.get());
  packet_->data = nullptr;
  packet_->size = 0;
  if (code >= 0) code = avcodec_receive_frame(context_.get(), frame_.get());
  if (code < 0)
    return fail(ErrorCode::kCorrupt, fmt::format("an access unit does not decode: {}", libav_error(code)));
  const auto format = static_cast<AVPixelFormat>(frame_->format);
  const bool damaged = frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0;
  const bool expected = frame_->width == width_ && frame_->height == height_ && holds(format, format_);
  if (damaged || !expected) {
    const int width = frame_->width, height = frame_->height;
    av_frame_unref(frame_.get());
    if (damaged) return fail(ErrorCode::kCorrupt, "an access unit decodes to a damaged picture");
    return fail(ErrorCode::kCorrupt, fmt::format("a picture of {}x{} came where {}x{} {} was announced",
                                                 width, height, width_, height_, name(format_)));
  }
  keyframe_needed_ = false;
  return take_picture(*frame_, format_, width_, height_);
}

}  // namespace copresence::video
