#pragma once

// Pictures to H.264, one access unit for each, at once: libx264 without B frames, lookahead or threads.
//
// The first picture is a keyframe (IDR, with its parameter sets); later ones only when asked for. Samples are
// full range and go to x264 from where they lie, with one exact result for one input. At quantiser 0 the
// decoder gives the very same samples back. Thread: one at a time; different encoders are independent.

#include <cstdint>
#include <optional>
#include <vector>

#include "common/frame/picture.h"
#include "common/result.h"
#include "common/video/libav_owners.h"
#include "common/video/video_settings.h"

namespace copresence::video {

enum class PictureKind { kDepth, kColor };

/// A constant rate: every stretch of pictures stays below it plus the buffer.
struct PictureRate {
  double kbps = 0;
  double buffer_kbit = 0;
};

struct PictureSettings {
  PictureKind kind = PictureKind::kDepth;
  Preset preset = Preset::kDense;
  PixelFormat format = PixelFormat::kGray8;
  int width = 0;  ///< even
  int height = 0;
  double frames_per_second = 30;  ///< nominal: what a rate in kbit/s is spread over
  int qp = 0;                     ///< constant quantiser, where there is no rate
  std::optional<PictureRate> rate = std::nullopt;
};

class PictureEncoder {
 public:
  /// Fails with kUnsupported when this machine's libavcodec lacks libx264 or libx264 refuses the settings.
  static Result<PictureEncoder> open(const PictureSettings& settings);

  /// The picture's access unit, Annex B.
  /// Requires a picture of the settings' format and size. Fails as libx264 does; the next picture is then a
  /// keyframe.
  Result<std::vector<std::uint8_t>> encode(const Picture& picture, bool keyframe);

  /// From the next picture on. Requires an encoder opened with a rate; numbers above 0.
  void set_rate(const PictureRate& rate);

  const PictureSettings& settings() const { return settings_; }

  /// Of the picture encoded last, counted as depth_qp is. Requires one.
  int qp() const { return qp_; }

 private:
  PictureEncoder(const PictureSettings& settings, CodecContext context, AvFrame frame, AvPacket packet);

  PictureSettings settings_;
  CodecContext context_;
  AvFrame frame_;
  AvPacket packet_;
  std::int64_t pictures_ = 0;
  bool keyframe_needed_ = true;
  int qp_ = 0;
};

}  // namespace copresence::video
