#pragma once

// FFmpeg's headers, and conversions of its error numbers and pixel formats. Private to this module.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/cpu.h>
#include <libavutil/opt.h>
}

#include <string>

#include "common/frame/picture.h"

namespace copresence::video {

/// Keeps FFmpeg from writing to standard error. Call this before opening a codec.
void silence_libav();

std::string libav_error(int code);

AVPixelFormat to_libav(PixelFormat format);

}  // namespace copresence::video
