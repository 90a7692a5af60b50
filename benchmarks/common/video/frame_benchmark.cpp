// Measures encoding and decoding of video in milliseconds per 640x480 frame. As in the capture
// server, recordings pass hole filling and depth coding first. Counters are Mbit/s at 30 frames/s.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/sensor/source.h"
#include "common/color/yuv420.h"
#include "common/depth/depth_codec.h"
#include "common/video/frame_decoder.h"
#include "common/video/frame_encoder.h"

namespace copresence::video {
namespace {

constexpr int kFrames = 60;

struct Content {
  StreamDescription stream;
  std::vector<PlanarFrame> frames;  // The first frame is a keyframe.
};

Content load(const std::string& path, const std::string& codec, bool lossless) {
  Content content;
  auto source = sensor::open_source(path, {.pace = sensor::SourceSettings::Pace::kFast});
  if (!source) return content;
  const sensor::SensorDescription& sensor = (*source)->description();
  content.stream.model = sensor.depth;
  content.stream.unit = sensor.unit;
  content.stream.has_color = sensor.has_color;
  const depth::DepthFormat format{sensor.depth.width, sensor.depth.height, sensor.unit, content.stream.range};
  auto encoder = depth::Encoder::open(codec, format).value();
  encoder.set_lossless(lossless);
  content.stream.codec = encoder.description();
  auto filler = hole_filling::open(hole_filling::Method::kJoint, hole_filling::Compute::kCpu,
                                   {format.width, format.height, format.unit, format.range})
                    .value();
  while (content.frames.size() < kFrames) {
    auto frame = (*source)->next({});
    if (!frame) break;
    if (!filler->fill(*frame)) break;
    auto planes = encoder.encode(frame->depth, frame->state, content.frames.empty());
    if (!planes) break;
    PlanarFrame planar;
    planar.metadata = frame->metadata;
    planar.depth = std::move(*planes);
    if (frame->color) color::rgb_to_yuv420(*frame->color, planar.color.emplace());
    content.frames.push_back(std::move(planar));
  }
  return content;
}

enum class Part { kBoth, kDepth };

struct Case {
  std::string recording;
  VideoSettings settings;
  Part part = Part::kBoth;
  std::string codec = "quantized";
};

const Content& content_of(const Case& which) {
  static std::map<std::tuple<std::string, std::string, bool>, Content> loaded;
  const bool lossless = which.settings.depth_qp == 0;
  const auto [place, is_new] = loaded.try_emplace({which.recording, which.codec, lossless});
  if (is_new) place->second = load(which.recording, which.codec, lossless);
  return place->second;
}

/// Returns the recording's frames in a loop, with rising numbers. Each pass begins with a keyframe.
PlanarFrame frame_of(const Content& content, const Case& which, std::uint64_t sequence) {
  PlanarFrame frame = content.frames[(sequence - 1) % content.frames.size()];
  frame.metadata.sequence = sequence;
  if (which.part == Part::kDepth) frame.color.reset();
  return frame;
}

void encode(benchmark::State& state, const Case& which) {
  const Content& content = content_of(which);
  if (content.frames.empty()) return state.SkipWithError("no such recording here");
  std::vector<PlanarFrame> frames;
  for (std::uint64_t i = 1; i <= content.frames.size(); ++i) frames.push_back(frame_of(content, which, i));
  FrameEncoder encoder = FrameEncoder::open(content.stream, which.settings).value();
  std::uint64_t sequence = 0;
  double depth_bytes = 0, color_bytes = 0;
  for (auto _ : state) {
    PlanarFrame& frame = frames[sequence % frames.size()];
    frame.metadata.sequence = ++sequence;
    const EncodedFrame encoded = encoder.encode(frame).value();
    depth_bytes += static_cast<double>(encoded.depth.size());
    color_bytes += static_cast<double>(encoded.color.size());
  }
  const double mbps_per_byte = 8e-6 * 30 / static_cast<double>(sequence);
  state.counters["depth_mbps"] = depth_bytes * mbps_per_byte;
  state.counters["color_mbps"] = color_bytes * mbps_per_byte;
}

void decode(benchmark::State& state, const Case& which) {
  const Content& content = content_of(which);
  if (content.frames.empty()) return state.SkipWithError("no such recording here");
  FrameEncoder encoder = FrameEncoder::open(content.stream, which.settings).value();
  std::vector<EncodedFrame> frames;
  for (std::uint64_t i = 1; i <= content.frames.size(); ++i) {
    frames.push_back(encoder.encode(frame_of(content, which, i)).value());
  }
  FrameDecoder decoder = FrameDecoder::open(content.stream).value();
  std::size_t i = 0;
  for (auto _ : state) {
    if (!decoder.decode(frames[i++ % frames.size()])) state.SkipWithError("a frame did not decode");
  }
}

std::vector<std::string> recordings() {
  const char* folder = std::getenv("COPRESENCE_RECORDINGS");
  const std::string real = folder ? folder : "../shared/recordings";
  return {"data/recordings/camera0.oni", real + "/office.oni", real + "/desk.oni", real + "/person.oni"};
}

const int kRegistered = [] {
  for (const std::string& recording : recordings()) {
    const std::string name = std::filesystem::path(recording).stem();
    const std::pair<const char*, Case> cases[] = {
        // The defaults of capture_server.
        {"live", {recording, {.preset = Preset::kLive, .depth_qp = 20}, Part::kBoth, "adaptive"}},
        {"both", {recording, {}, Part::kBoth}},
        {"depth", {recording, {}, Part::kDepth}},
        {"depth_lossless", {recording, {.depth_qp = 0}, Part::kDepth}},
        {"depth_2_mbps", {recording, {.depth_kbps = 2000}, Part::kDepth}},
    };
    for (const auto& [what, which] : cases) {
      benchmark::RegisterBenchmark(("encode/" + name + "/" + what).c_str(), encode, which)
          ->Unit(benchmark::kMillisecond);
      benchmark::RegisterBenchmark(("decode/" + name + "/" + what).c_str(), decode, which)
          ->Unit(benchmark::kMillisecond);
    }
  }
  return 0;
}();

}  // namespace
}  // namespace copresence::video
