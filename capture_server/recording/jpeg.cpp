#include "capture_server/recording/jpeg.h"

#include <turbojpeg.h>

#include <cassert>

namespace copresence::recording {

void JpegEncoder::Close::operator()(void* codec) const {
  tjDestroy(codec);
}

JpegEncoder::JpegEncoder() : codec_(tjInitCompress()) {}

Result<void> JpegEncoder::encode(const ColorImage& image, int quality, std::vector<std::uint8_t>& bytes) {
  assert(quality >= 1 && quality <= 100);
  const unsigned long most = tjBufSize(image.width(), image.height(), TJSAMP_420);
  if (!codec_ || most == static_cast<unsigned long>(-1))
    return fail(ErrorCode::kUnsupported, tjGetErrorStr2(nullptr));
  const auto* const from = reinterpret_cast<const std::uint8_t*>(image.data());
  bytes.resize(most);
  unsigned char* to = bytes.data();
  unsigned long size = most;
  if (tjCompress2(codec_.get(), from, image.width(), 0, image.height(), TJPF_RGB, &to, &size, TJSAMP_420,
                  quality, TJFLAG_NOREALLOC | TJFLAG_ACCURATEDCT) != 0) {
    return fail(ErrorCode::kUnsupported, tjGetErrorStr2(codec_.get()));
  }
  bytes.resize(size);
  return {};
}

bool decode_jpeg(std::span<const std::uint8_t> bytes, ColorImage& image) {
  const std::unique_ptr<void, decltype(&tjDestroy)> codec(tjInitDecompress(), &tjDestroy);
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (!codec || tjDecompressHeader3(codec.get(), bytes.data(), bytes.size(), &width, &height, &subsampling,
                                    &colorspace) != 0) {
    return false;
  }
  if (width != image.width() || height != image.height()) return false;
  auto* const to = reinterpret_cast<std::uint8_t*>(image.data());
  // The number of scans is limited, since each one costs much time and few bytes.
  return tjDecompress2(codec.get(), bytes.data(), bytes.size(), to, width, 0, height, TJPF_RGB,
                       TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) == 0 ||
         tjGetErrorCode(codec.get()) == TJERR_WARNING;
}

}  // namespace copresence::recording
