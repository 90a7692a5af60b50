// Measures the effect of the temporal filters on bitrates and errors.
//
// Usage: filter_figures [RECORDING.oni]
//
// Without a recording, a simulated Kinect shows a still scene and a scene with a moving figure.
// Each frame passes the server's FrameEncoding, with and without the filters, and is decoded again.
// Depth is compared with the true depth. Colour is compared with the colour before noise, in the
// coded planes. The first 120 of 180 frames are not measured.
//
// With a recording, the depth is filtered. Still pixels are compared with their mean over 16
// frames.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/sensor/source.h"
#include "capture_server/temporal_filter/depth_filter.h"
#include "common/color/yuv420.h"
#include "common/depth/depth_codec.h"
#include "common/video/frame_decoder.h"
#include "simulation/sensor/simulated_kinect.h"

namespace copresence::temporal_filter {
namespace {

constexpr int kWidth = 640, kHeight = 480, kFrames = 180, kWarmUp = 120;
constexpr std::uint32_t kSeed = 1;
constexpr DepthUnit kUnit = DepthUnit::kMillimetre;

struct Errors {
  double squared_steps = 0, gross = 0, pixels = 0;
  double squared_color = 0, samples = 0;
  double keyframes = 0, depth_bytes = 0, mask_bytes = 0, color_bytes = 0, frames = 0;

  /// Errors above this limit are counted but not averaged, since they show another surface.
  static constexpr double kGrossSteps = 8;

  void add_depth(double z_m, double truth_m) {
    const double steps = (z_m - truth_m) / kKinectV1Noise.step_m(truth_m);
    ++pixels;
    if (std::abs(steps) > kGrossSteps) return void(++gross);
    squared_steps += steps * steps;
  }
  void add_color(const Picture& shown, const simulation::NoiseFreeColors& colors) {
    ColorImage image(colors.width(), colors.height());
    const auto channel = [](int value) {
      return static_cast<std::uint8_t>(std::clamp((value + 8) / 16, 0, 255));
    };
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      const simulation::NoiseFreeColor& color = colors.data()[i];
      image.data()[i] = {channel(color.r), channel(color.g), channel(color.b)};
    }
    Picture truth;
    color::rgb_to_yuv420(image, truth);
    for (int plane = 0; plane < truth.planes(); ++plane) {
      for (std::size_t i = 0; i < truth.plane8(plane).size(); ++i) {
        const double error = shown.plane8(plane)[i] - truth.plane8(plane)[i];
        squared_color += error * error;
        ++samples;
      }
    }
  }
  void print(const std::string& title) const {
    const double mbps = 8 * 30 / 1e6 / frames;
    fmt::print("{:28} depth {:5.2f} Mbit/s, mask {:5.3f}; error {:.3f} steps, {:.3f} % beyond {} steps; ",
               title, depth_bytes * mbps, mask_bytes * mbps, std::sqrt(squared_steps / (pixels - gross)),
               100 * gross / pixels, kGrossSteps);
    fmt::print("colour {:.2f} Mbit/s, PSNR {:.2f} dB; {} keyframes\n", color_bytes * mbps,
               10 * std::log10(255.0 * 255.0 * samples / squared_color), keyframes);
  }
};

sensor::SensorDescription description_of(const CameraModel& model) {
  sensor::SensorDescription sensor;
  sensor.depth = sensor.color = model;
  sensor.unit = kUnit;
  sensor.has_color = true;
  sensor.registered = true;
  return sensor;
}

/// Runs the simulated camera. The figure walks if `moves` is true, and stands otherwise.
Errors simulate(bool moves, Mode mode) {
  const auto world =
      std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("room").value());
  const auto poses = simulation::kinect_poses(2);
  auto kinect = simulation::SimulatedKinect::make(world, simulation::kinect_model(kWidth, kHeight), poses, 0,
                                                  kUnit, kSeed)
                    .value();
  const simulation::ColorResponse response(kWidth, kHeight, kSeed, 0);
  server::EncodingSettings settings;
  settings.name = "camera0";
  settings.temporal_filter = mode;
  auto encoding = server::FrameEncoding::open(description_of(kinect.model()), nullptr, settings).value();
  auto video = video::FrameDecoder::open(encoding.description()).value();
  const StreamDescription& stream = encoding.description();
  auto depth =
      depth::Decoder::open(stream.codec, {kWidth, kHeight, stream.unit, stream.range, stream.noise}).value();
  Errors errors;
  for (std::uint64_t number = 1; number <= kFrames; ++number) {
    RgbdFrame frame;
    frame.metadata.sequence = number;
    const double phase = moves ? static_cast<double>(number) / simulation::kPeriodFrames : 0.15;
    kinect.capture(phase, number, frame.depth, frame.color.emplace());
    frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
    const DepthImage raw = frame.depth;
    const auto encoded = encoding.encode(std::move(frame), number == 1).value();
    const auto planes = video.decode(encoded).value();
    DepthImage shown;
    StateImage states;
    if (!depth.decode(planes.depth, shown, states)) std::abort();
    if (number <= kWarmUp) continue;
    errors.depth_bytes += static_cast<double>(encoded.depth.size());
    errors.mask_bytes += static_cast<double>(planes.depth.validity_mask.size());
    errors.color_bytes += static_cast<double>(encoded.color.size());
    ++errors.frames;
    errors.keyframes += encoded.keyframe;
    for (std::size_t i = 0; i < shown.pixels().size(); ++i) {
      const double truth = kinect.truth().depth_m.data()[i];
      if (raw.data()[i] > 0 && shown.data()[i] > 0 && truth > 0)
        errors.add_depth(shown.data()[i] * metres_per_unit(kUnit), truth);
    }
    simulation::NoiseFreeColors noise_free;
    response.apply_response(kinect.truth().color, noise_free);
    errors.add_color(*planes.color, noise_free);
  }
  return errors;
}

/// Prints the error of a recording's still pixels before and after the filter.
int measure_recording(const std::string& path) {
  auto source = sensor::open_source(path, {sensor::SourceSettings::Pace::kFast, false});
  if (!source) {
    fmt::print(stderr, "filter_figures: {}\n", source.error().what);
    return 1;
  }
  const auto& sensor = (*source)->description();
  DepthFilter filter(sensor.depth.width, sensor.depth.height, sensor.unit, sensor.noise);
  constexpr std::size_t kMeanFrames = 16;
  std::vector<DepthImage> raw, filtered;
  double raw_squares = 0, filtered_squares = 0, pixels = 0;
  const double unit = metres_per_unit(sensor.unit);
  while (auto frame = (*source)->next({})) {
    StateImage state(frame->depth.width(), frame->depth.height(), DepthState::kMeasured);
    for (std::size_t i = 0; i < state.pixels().size(); ++i) {
      if (frame->depth.data()[i] == 0) state.data()[i] = DepthState::kHole;
    }
    raw.push_back(frame->depth);
    filter.apply(frame->depth, state);
    filtered.push_back(std::move(frame->depth));
    if (raw.size() < kMeanFrames) continue;
    for (std::size_t i = 0; i < state.pixels().size(); ++i) {
      double sum = 0;
      std::uint16_t least = 65535, most = 0;
      for (const DepthImage& depth : raw) {
        sum += depth.data()[i];
        least = std::min(least, depth.data()[i]);
        most = std::max(most, depth.data()[i]);
      }
      const double mean = sum / kMeanFrames, step = kKinectV1Noise.step_m(mean * unit) / unit;
      if (least == 0 || most - least > 3.5 * step) continue;  // The pixel is not still.
      for (std::size_t f = kMeanFrames / 2; f < kMeanFrames; ++f) {
        if (filtered[f].data()[i] == 0) continue;  // The filter still shows a hole.
        raw_squares += std::pow((raw[f].data()[i] - mean) / step, 2);
        filtered_squares += std::pow((filtered[f].data()[i] - mean) / step, 2);
        ++pixels;
      }
    }
    raw.clear();
    filtered.clear();
  }
  if (pixels == 0) {
    fmt::print(stderr, "filter_figures: {}: no pixel stands still for {} frames\n", path, kMeanFrames);
    return 1;
  }
  fmt::print(
      "{}: error of still pixels against their mean of {} frames: {:.3f} steps as measured, {:.3f} "
      "filtered\n",
      path, kMeanFrames, std::sqrt(raw_squares / pixels), std::sqrt(filtered_squares / pixels));
  return 0;
}

}  // namespace
}  // namespace copresence::temporal_filter

int main(int argc, char** argv) {
  using namespace copresence::temporal_filter;
  if (argc == 2) return measure_recording(argv[1]);
  if (argc != 1) {
    fmt::print(stderr, "usage: filter_figures [RECORDING.oni]\n");
    return 2;
  }
  for (const bool moves : {false, true}) {
    for (const Mode mode : {Mode::kOff, Mode::kAuto})
      simulate(moves, mode)
          .print(fmt::format("{}, filter {}:", moves ? "figure moves" : "still scene",
                             mode == Mode::kAuto ? "auto" : "off"));
  }
}
