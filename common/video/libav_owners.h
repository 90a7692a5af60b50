#pragma once

// Smart pointers to FFmpeg's objects, without FFmpeg's headers.

#include <memory>

struct AVCodecContext;
struct AVFrame;
struct AVPacket;

namespace copresence::video {

struct CodecContextDeleter {
  void operator()(AVCodecContext* context) const;
};
struct AvFrameDeleter {
  void operator()(AVFrame* frame) const;
};
struct AvPacketDeleter {
  void operator()(AVPacket* packet) const;
};

using CodecContext = std::unique_ptr<AVCodecContext, CodecContextDeleter>;
using AvFrame = std::unique_ptr<AVFrame, AvFrameDeleter>;
using AvPacket = std::unique_ptr<AVPacket, AvPacketDeleter>;

}  // namespace copresence::video
