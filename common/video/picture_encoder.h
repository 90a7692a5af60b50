#pragma once

// Encodes each picture at once to one H.264 access unit. Uses libx264 without B frames, lookahead
// or threads.
//
// The first picture is a keyframe (IDR, with its parameter sets). Later keyframes are made only on
// request. Samples are full range and are not copied for x264. Equal inputs give equal outputs. At
// QP 0 the decoder returns exactly the same samples. Thread: one thread at a time; different
// encoders are independent.

#include <cstdint>
#include <optional>
#include <vector>

#include "common/frame/picture.h"
#include "common/result.h"
#include "common/video/libav_owners.h"
#include "common/video/video_settings.h"

namespace copresence::video {

enum class PictureKind { kDepth, kColor };

/// A constant bit rate: any sequence of pictures stays below the rate plus the buffer.
struct PictureRate {
  double kbps = 0;
  double buffer_kbit = 0;
};

struct PictureSettings {
  PictureKind kind = PictureKind::kDepth;
  Preset preset = Preset::kDense;
  PixelFormat format = PixelFormat::kGray8;
  int width = 0;  ///< Even.
  int height = 0;
  double frames_per_second = 30;  ///< Nominal rate; converts kbit/s to bits per picture.
  int qp = 0;                     ///< Constant QP, used if there is no rate.
  std::optional<PictureRate> rate = std::nullopt;
};

class PictureEncoder {
 public:
  /// Fails with kUnsupported if libavcodec has no libx264, or if libx264 rejects the settings.
  static Result<PictureEncoder> open(const PictureSettings& settings);

  /// Returns the picture's access unit in Annex B form. Requires a picture of the settings' format
  /// and size. Fails if libx264 does; the next picture is then a keyframe.
  Result<std::vector<std::uint8_t>> encode(const Picture& picture, bool keyframe);

  /// Changes the rate from the next picture on. Requires an encoder with a rate, and numbers above
  /// 0.
  void set_rate(const PictureRate& rate);

  const PictureSettings& settings() const { return settings_; }

  /// QP of the last encoded picture, on the scale of depth_qp. Requires an encoded picture.
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
