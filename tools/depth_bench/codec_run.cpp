#include "tools/depth_bench/codec_run.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "common/depth/depth_codec.h"
#include "common/video/frame_decoder.h"
#include "common/video/frame_encoder.h"

namespace copresence::depth_bench {

std::string Setting::text() const {
  return qp ? "qp=" + std::to_string(*qp) : "kbps=" + std::to_string(kbps.value_or(0));
}

Result<Row> run_codec(const DepthRecording& recording, const std::string& codec, const Setting& setting,
                      Snapshot* snapshot) {
  const depth::DepthFormat& format = recording.format;
  auto depth_encoder = depth::Encoder::open(codec, format);
  if (!depth_encoder) return fail(depth_encoder.error());
  depth_encoder->set_sensor_levels(recording.levels);
  depth_encoder->set_lossless(setting.qp == 0);
  auto depth_decoder = depth::Decoder::open(depth_encoder->description(), format);
  if (!depth_decoder) return fail(depth_decoder.error());
  StreamDescription stream;
  stream.model.width = format.width;
  stream.model.height = format.height;
  stream.unit = format.unit;
  stream.range = format.range;
  stream.codec = depth_encoder->description();
  depth_encoder->set_bitrate(setting.kbps, stream.frames_per_second);
  video::VideoSettings video_settings;
  video_settings.depth_qp = setting.qp.value_or(video_settings.depth_qp);
  video_settings.depth_kbps = setting.kbps;
  video_settings.preset = setting.preset;
  auto encoder = video::FrameEncoder::open(stream, video_settings);
  if (!encoder) return fail(encoder.error());
  auto decoder = video::FrameDecoder::open(stream);
  if (!decoder) return fail(decoder.error());

  Tally tally;
  DepthError error(format.unit);
  DepthImage back;
  StateImage states_back;
  for (std::size_t i = 0; i < recording.depth.size(); ++i) {
    const double start = thread_ms();
    auto planes = depth_encoder->encode(recording.depth[i], recording.states[i], i == 0);
    if (!planes) return fail(planes.error());
    PlanarFrame frame;
    frame.metadata.sequence = i + 1;
    frame.depth = std::move(*planes);
    const auto encoded = encoder->encode(frame);
    if (!encoded) return fail(encoded.error());
    const double coded = thread_ms();
    auto decoded = decoder->decode(*encoded);
    if (!decoded) return fail(decoded.error());
    if (const auto done = depth_decoder->decode(decoded->depth, back, states_back); !done)
      return fail(done.error());
    tally.decode_ms.push_back(thread_ms() - coded);
    tally.encode_ms.push_back(coded - start);
    tally.bytes += encoded->depth.size();
    tally.largest = std::max<std::uint64_t>(tally.largest, encoded->depth.size());
    tally.mask_bytes += frame.depth.validity_mask.size();
    error.add(recording.depth[i], recording.states[i], back, states_back);
    if (snapshot && i == recording.depth.size() / 2) {
      *snapshot = {std::move(frame.depth.picture), std::move(decoded->depth.picture), recording.depth[i],
                   back};
    }
  }
  Row row;
  row.codec = codec;
  row.pixel_format = name(stream.codec.format);
  row.setting = setting.text();
  conclude(tally, error, row);
  return row;
}

std::vector<std::string> tuning_candidates() {
  std::vector<std::string> names(depth::codec_names().begin(), depth::codec_names().end());
  for (const char* codec : {"triangle", "direct"}) {
    for (const char* period : {"0.3", "1", "1.6"}) names.push_back(std::string(codec) + ":period=" + period);
  }
  return names;
}

Result<std::vector<Row>> tune(const DepthRecording& recording, int kbps, video::Preset preset,
                              tools::Progress& progress) {
  std::vector<Row> rows;
  for (const std::string& codec : tuning_candidates()) {
    const Setting setting{std::nullopt, kbps, preset};
    progress.begin(codec + ' ' + setting.text());
    auto row = run_codec(recording, codec, setting);
    if (!row) return fail(row.error());
    rows.push_back(std::move(*row));
  }
  std::sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) {
    const auto exceeds = [&](const Row& row) { return row.mbps * 1000 > 1.1 * kbps; };
    return std::tuple(exceeds(a), a.rmse_steps) < std::tuple(exceeds(b), b.rmse_steps);
  });
  return rows;
}

}  // namespace copresence::depth_bench
