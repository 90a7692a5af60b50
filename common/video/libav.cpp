#include "common/video/libav.h"

#include "common/video/libav_owners.h"

namespace copresence::video {

void silence_libav() {
  av_log_set_level(AV_LOG_QUIET);
}

std::string libav_error(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

AVPixelFormat to_libav(PixelFormat format) {
  switch (format) {
    case PixelFormat::kGray8:
      return AV_PIX_FMT_GRAY8;
    case PixelFormat::kGray10:
      return AV_PIX_FMT_GRAY10;
    case PixelFormat::kYuv420:
      return AV_PIX_FMT_YUV420P;
    case PixelFormat::kYuv444:
      return AV_PIX_FMT_YUV444P;
  }
  return AV_PIX_FMT_NONE;
}

void CodecContextDeleter::operator()(AVCodecContext* context) const {
  avcodec_free_context(&context);
}
void AvFrameDeleter::operator()(AVFrame* frame) const {
  av_frame_free(&frame);
}
void AvPacketDeleter::operator()(AVPacket* packet) const {
  av_packet_free(&packet);
}

}  // namespace copresence::video
