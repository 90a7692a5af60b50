#pragma once

// FFmpeg's C objects as owners, its error numbers as words. Private to this room's .cpp files.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/cpu.h>
#include <libavutil/opt.h>
}

#include <string>

#include "common/frame/picture.h"

namespace copresence::video {

/// FFmpeg writes to standard error unless told not to; a room doesn't log. Call before opening a codec.
void silence_libav();

std::string libav_error(int code);

AVPixelFormat to_libav(PixelFormat format);

}  // namespace copresence::video
