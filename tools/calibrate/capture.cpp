#include "tools/calibrate/capture.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture_server/source.h"

namespace copresence::calibrate {

CLI::Option* add_recording_option(CLI::App& parser, std::vector<NamedRecording>& recordings) {
  return parser
      .add_option_function<std::vector<std::string>>(
          "--recording",
          [&recordings](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) {
              const auto equals = text.find('=');
              if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
                throw CLI::ValidationError("--recording", "\"" + text + "\" is not NAME=FILE.oni");
              }
              NamedRecording recording{text.substr(0, equals), text.substr(equals + 1)};
              const bool twice =
                  std::any_of(recordings.begin(), recordings.end(),
                              [&](const NamedRecording& other) { return other.name == recording.name; });
              if (twice) throw CLI::ValidationError("--recording", "two are called " + recording.name);
              recordings.push_back(std::move(recording));
            }
          },
          "a camera's name and its recording, NAME=FILE.oni; once per camera")
      ->take_all()
      ->allow_extra_args(false);
}

Result<Capture> Capture::open(const NamedRecording& recording, const scene::Camera* known, Form form) {
  sensor::SourceSettings settings;
  settings.pace = sensor::SourceSettings::Pace::kFast;
  auto source = open_source(recording.file, settings);
  if (!source) return fail(source.error());
  sensor::SensorDescription told = (*source)->description();
  if (known) {
    if (known->model.width != told.depth.width || known->model.height != told.depth.height) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("the scene file says that camera \"{}\" gives {}x{} pixels, but {} has {}x{}",
                              known->name, known->model.width, known->model.height, recording.file,
                              told.depth.width, told.depth.height));
    }
    told.depth = known->model;
    if (known->color) {
      told.color = known->color->model;
      told.color_from_depth = known->color->color_from_depth;
      told.registered = false;
    }
    if (known->world_from_camera) told.world_from_camera = known->world_from_camera;
  }
  const bool passes_through = told.registered || form == Form::kAsDelivered;
  auto registration =
      registration::Registration::open({told.depth, told.has_color ? std::optional(told.color) : std::nullopt,
                                        told.color_from_depth, told.unit, passes_through});
  if (!registration) return fail(registration.error());
  return Capture(recording.name, std::move(*source), std::move(told), std::move(*registration));
}

Capture::Capture(std::string name, std::unique_ptr<sensor::FrameSource> source,
                 sensor::SensorDescription sensor, registration::Registration registration)
    : name_(std::move(name)),
      source_(std::move(source)),
      sensor_(std::move(sensor)),
      registration_(std::move(registration)) {}

Result<RgbdFrame> Capture::next() {
  auto frame = source_->next({});
  if (!frame) return fail(frame.error());
  return registration_.apply(std::move(*frame));
}

Result<std::vector<RgbdFrame>> frames_of(Capture& capture, std::size_t most) {
  const std::uint64_t all = capture.frames().value_or(most);
  const std::uint64_t wanted = std::clamp<std::uint64_t>(most, 1, std::max<std::uint64_t>(all, 1));
  std::vector<RgbdFrame> kept;
  for (std::uint64_t number = 0; kept.size() < wanted; ++number) {
    auto frame = capture.next();
    if (!frame && frame.error().code == ErrorCode::kEndOfStream) break;
    if (!frame) return fail(frame.error());
    if (number >= kept.size() * all / wanted) kept.push_back(std::move(*frame));
  }
  if (kept.empty()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("the recording of camera \"{}\" has no frame", capture.name()));
  }
  return kept;
}

}  // namespace copresence::calibrate
