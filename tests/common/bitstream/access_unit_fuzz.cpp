// Arbitrary access units: the input is a byte that selects the pixel format, then an access unit.
// The decoders must not crash, and decoded pictures must have the stream's format and size.

#include <cstdlib>
#include <span>

#include "common/video/frame_decoder.h"

namespace copresence::bitstream {
namespace {

constexpr int kWidth = 32, kHeight = 32;
constexpr PixelFormat kFormats[] = {PixelFormat::kGray8, PixelFormat::kGray10, PixelFormat::kYuv420,
                                    PixelFormat::kYuv444};

bool fits(const Picture& picture, PixelFormat format) {
  return picture.format() == format && picture.width() == kWidth && picture.height() == kHeight;
}

/// Decoders of one stream. They are kept between inputs, so that an input also meets the state that
/// others left.
struct Decoders {
  video::PictureDecoder pictures;
  video::FrameDecoder frames;

  static Decoders open(PixelFormat format) {
    StreamDescription stream;
    stream.model = camera_from_field_of_view(kWidth, kHeight, 1, 1);
    stream.codec.format = format;
    return {video::PictureDecoder::open(format, kWidth, kHeight).value(),
            video::FrameDecoder::open(stream).value()};
  }
};

void decode_anything(std::size_t choice, std::span<const std::uint8_t> bytes) {
  static Decoders decoders[] = {Decoders::open(kFormats[0]), Decoders::open(kFormats[1]),
                                Decoders::open(kFormats[2]), Decoders::open(kFormats[3])};
  const auto picture = decoders[choice].pictures.decode(bytes);
  if (picture && !fits(*picture, kFormats[choice])) std::abort();
  EncodedFrame encoded;
  encoded.depth.assign(bytes.begin(), bytes.end());
  const auto frame = decoders[choice].frames.decode(encoded);
  if (frame && frame->depth.residuals.empty() && !fits(frame->depth.picture, kFormats[choice])) std::abort();
}

}  // namespace
}  // namespace copresence::bitstream

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace copresence::bitstream;
  if (size > 0) decode_anything(data[0] & 3, std::span(data, size).subspan(1));
  return 0;
}
