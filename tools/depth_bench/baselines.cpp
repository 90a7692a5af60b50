#include "tools/depth_bench/baselines.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "common/video/picture_decoder.h"
#include "common/video/picture_encoder.h"
#include "tools/depth_bench/holoimage.h"
#include "tools/depth_bench/rvl.h"

namespace copresence::depth_bench {
namespace {

constexpr std::array<std::string_view, 5> kNames{"rvl", "rvl_zstd", "png", "split16", "holoimage"};
constexpr int kZstdLevel = 1;  // Level 1 is fast enough for a live camera.
constexpr int kPngLevel = 1;
constexpr int kLossyQp = 12;

using Bytes = std::vector<std::uint8_t>;

struct Lossless {
  std::function<Bytes(const DepthImage&)> encode;
  std::function<void(const Bytes&, DepthImage&)> decode;
};

Bytes with_zstd(const Bytes& bytes) {
  Bytes packed(ZSTD_compressBound(bytes.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kZstdLevel));
  return packed;
}

Bytes without_zstd(const Bytes& packed) {
  Bytes bytes(ZSTD_getFrameContentSize(packed.data(), packed.size()));
  ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  return bytes;
}

Bytes to_png(const DepthImage& depth) {
  const cv::Mat mat(depth.height(), depth.width(), CV_16U, const_cast<std::uint16_t*>(depth.data()));
  Bytes bytes;
  cv::imencode(".png", mat, bytes, {cv::IMWRITE_PNG_COMPRESSION, kPngLevel});
  return bytes;
}

void from_png(const Bytes& bytes, DepthImage& depth) {
  cv::Mat mat(depth.height(), depth.width(), CV_16U, depth.data());
  cv::imdecode(bytes, cv::IMREAD_UNCHANGED, &mat);
}

Lossless lossless(std::string_view name) {
  if (name == "png") return {to_png, from_png};
  const bool zstd = name == "rvl_zstd";
  return {[zstd](const DepthImage& depth) {
            Bytes bytes = encode_rvl(depth.pixels());
            return zstd ? with_zstd(bytes) : bytes;
          },
          [zstd](const Bytes& bytes, DepthImage& depth) {
            decode_rvl(zstd ? without_zstd(bytes) : bytes, depth.pixels());
          }};
}

// Returns the validity states of decoded depth. Baselines code holes as zeros and cannot mark
// filled pixels, so filled pixels count as correct.
StateImage states_of(const DepthImage& depth, const StateImage& original) {
  StateImage states(depth.width(), depth.height(), DepthState::kHole);
  for (std::size_t i = 0; i < states.pixels().size(); ++i) {
    if (depth.data()[i] == 0) continue;
    states.data()[i] =
        original.data()[i] == DepthState::kFilled ? DepthState::kFilled : DepthState::kMeasured;
  }
  return states;
}

void add(const DepthRecording& recording, std::size_t i, const DepthImage& back, std::size_t bytes,
         Tally& tally, DepthError& error) {
  tally.bytes += bytes;
  tally.largest = std::max<std::uint64_t>(tally.largest, bytes);
  error.add(recording.depth[i], recording.states[i], back, states_of(back, recording.states[i]));
}

Row run_lossless(const DepthRecording& recording, const std::string& name) {
  const Lossless codec = lossless(name);
  Tally tally;
  DepthError error(recording.format.unit);
  DepthImage back(recording.format.width, recording.format.height);
  for (std::size_t i = 0; i < recording.depth.size(); ++i) {
    const double start = thread_ms();
    const Bytes bytes = codec.encode(recording.depth[i]);
    const double coded = thread_ms();
    codec.decode(bytes, back);
    tally.decode_ms.push_back(thread_ms() - coded);
    tally.encode_ms.push_back(coded - start);
    add(recording, i, back, bytes.size(), tally, error);
  }
  Row row;
  row.pixel_format = "none";
  row.setting = "lossless";
  conclude(tally, error, row);
  return row;
}

// Makes a picture of twice the height: high bytes in the upper half, low bytes in the lower half.
Picture split(const DepthImage& depth) {
  Picture picture(PixelFormat::kGray8, depth.width(), 2 * depth.height());
  const auto samples = picture.plane8(0);
  const std::size_t half = depth.pixels().size();
  for (std::size_t i = 0; i < half; ++i) {
    samples[i] = static_cast<std::uint8_t>(depth.data()[i] >> 8);
    samples[half + i] = static_cast<std::uint8_t>(depth.data()[i]);
  }
  return picture;
}

void join(const Picture& picture, DepthImage& depth) {
  const auto samples = picture.plane8(0);
  const std::size_t half = depth.pixels().size();
  for (std::size_t i = 0; i < half; ++i) {
    depth.data()[i] = static_cast<std::uint16_t>(samples[i] << 8 | samples[half + i]);
  }
}

// A baseline that uses H.264 and no validity mask.
struct Lossy {
  PixelFormat format;
  int height;
  std::function<Picture(const DepthImage&)> encode;
  std::function<void(const Picture&, DepthImage&)> decode;
};

Lossy lossy(std::string_view name, const depth::DepthFormat& format) {
  if (name == "split16") return {PixelFormat::kGray8, 2 * format.height, split, join};
  const Holoimage holoimage(format);
  return {PixelFormat::kYuv444, format.height,
          [holoimage](const DepthImage& depth) { return holoimage.encode(depth); },
          [holoimage](const Picture& picture, DepthImage& depth) { holoimage.decode(picture, depth); }};
}

Result<Row> run_lossy(const DepthRecording& recording, const std::string& baseline) {
  const Lossy codec = lossy(baseline, recording.format);
  video::PictureSettings settings;
  settings.format = codec.format;
  settings.width = recording.format.width;
  settings.height = codec.height;
  settings.qp = kLossyQp;
  settings.preset = video::Preset::kLive;
  auto encoder = video::PictureEncoder::open(settings);
  if (!encoder) return fail(encoder.error());
  auto decoder = video::PictureDecoder::open(codec.format, settings.width, settings.height);
  if (!decoder) return fail(decoder.error());
  Tally tally;
  DepthError error(recording.format.unit);
  DepthImage back(recording.format.width, recording.format.height);
  for (std::size_t i = 0; i < recording.depth.size(); ++i) {
    const double start = thread_ms();
    const auto access_unit = encoder->encode(codec.encode(recording.depth[i]), i == 0);
    if (!access_unit) return fail(access_unit.error());
    const double coded = thread_ms();
    const auto picture = decoder->decode(*access_unit);
    if (!picture) return fail(picture.error());
    codec.decode(*picture, back);
    tally.decode_ms.push_back(thread_ms() - coded);
    tally.encode_ms.push_back(coded - start);
    add(recording, i, back, access_unit->size(), tally, error);
  }
  Row row;
  row.pixel_format = copresence::name(codec.format);
  row.setting = "qp=" + std::to_string(kLossyQp);
  conclude(tally, error, row);
  return row;
}

}  // namespace

std::span<const std::string_view> baseline_names() {
  return kNames;
}

bool is_baseline(std::string_view name) {
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

Result<Row> run_baseline(const DepthRecording& recording, const std::string& name) {
  assert(is_baseline(name));
  const bool is_lossy = name == "split16" || name == "holoimage";
  Result<Row> row = is_lossy ? run_lossy(recording, name) : Result<Row>(run_lossless(recording, name));
  if (row) row->codec = name;
  return row;
}

}  // namespace copresence::depth_bench
