#include "tools/calibrate/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "capture_server/sensor/source.h"
#include "common/wire/host_port.h"
#include "tools/calibrate/stream_source.h"

namespace copresence::calibrate {

namespace {

CLI::Option* add_source_option(CLI::App& parser, std::vector<NamedSource>& sources, const std::string& flag,
                               const std::string& form, const std::string& help) {
  const bool is_stream = flag == "--stream";
  return parser
      .add_option_function<std::vector<std::string>>(
          flag,
          [&sources, flag, form, is_stream](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) {
              const auto equals = text.find('=');
              if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
                throw CLI::ValidationError(flag, "\"" + text + "\" is not " + form);
              }
              NamedSource source{text.substr(0, equals), text.substr(equals + 1), is_stream};
              if (const auto parsed = wire::parse_host_port(source.from); is_stream && !parsed) {
                throw CLI::ValidationError(flag, parsed.error().what);
              }
              const bool twice = std::any_of(sources.begin(), sources.end(), [&](const NamedSource& other) {
                return other.name == source.name;
              });
              if (twice) throw CLI::ValidationError(flag, "two are called " + source.name);
              sources.push_back(std::move(source));
            }
          },
          help)
      ->take_all()
      ->allow_extra_args(false);
}

}  // namespace

SourceOptions add_source_options(CLI::App& parser, std::vector<NamedSource>& sources, std::size_t fewest,
                                 std::size_t most) {
  SourceOptions options{
      add_source_option(parser, sources, "--recording", "NAME=FILE.oni",
                        "a camera's name and its recording, NAME=FILE.oni; once per camera"),
      add_source_option(parser, sources, "--stream", "NAME=HOST:PORT",
                        "a camera's name and where its running capture_server listens, NAME=HOST:PORT; once "
                        "per camera, instead of a recording")};
  parser.parse_complete_callback([&sources, fewest, most] {
    if (sources.size() >= fewest && sources.size() <= most) return;
    throw CLI::ValidationError("--recording and --stream", fmt::format("{} in all, but {} to {} are needed",
                                                                       sources.size(), fewest, most));
  });
  return options;
}

Result<Capture> Capture::open(const NamedSource& source, const scene::Camera* known, Form form) {
  sensor::SourceSettings settings;
  settings.pace = sensor::SourceSettings::Pace::kFast;
  auto frames = source.is_stream ? open_stream(source.from) : sensor::open_source(source.from, settings);
  if (!frames) return fail(frames.error());
  sensor::SensorDescription told = (*frames)->description();
  if (known) {
    if (known->model.width != told.depth.width || known->model.height != told.depth.height) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("the scene file says that camera \"{}\" gives {}x{} pixels, but {} has {}x{}",
                              known->name, known->model.width, known->model.height, source.from,
                              told.depth.width, told.depth.height));
    }
    told.depth = known->model;
    if (known->color && !source.is_stream) {
      told.color = known->color->model;
      told.color_from_depth = known->color->color_from_depth;
      told.registered = false;
    }
    if (known->world_from_camera) told.world_from_camera = known->world_from_camera;
  }
  const bool passes_through = told.registered || form == Form::kAsDelivered;
  auto registration =
      registration::Registration::open({told.depth, told.has_color ? std::optional(told.color) : std::nullopt,
                                        told.color_from_depth, told.unit, passes_through, told.noise});
  if (!registration) return fail(registration.error());
  return Capture(source.name, source.is_stream, std::move(*frames), std::move(told),
                 std::move(*registration));
}

Capture::Capture(std::string name, bool is_stream, std::unique_ptr<sensor::FrameSource> source,
                 sensor::SensorDescription sensor, registration::Registration registration)
    : name_(std::move(name)),
      is_stream_(is_stream),
      source_(std::move(source)),
      sensor_(std::move(sensor)),
      registration_(std::move(registration)) {}

Result<RgbdFrame> Capture::next() {
  auto frame = source_->next({});
  if (!frame) return fail(frame.error());
  return registration_.apply(std::move(*frame));
}

Result<void> try_all(std::span<const NamedSource> sources, const scene::Scene* scene) {
  for (const NamedSource& source : sources) {
    const auto capture = Capture::open(source, scene ? scene->find(source.name) : nullptr);
    if (!capture) return fail(capture.error());
  }
  return {};
}

std::size_t frames_to_look_at(const Capture& capture, std::size_t most) {
  const std::uint64_t all = capture.frames().value_or(most);
  return std::clamp<std::uint64_t>(most, 1, std::max<std::uint64_t>(all, 1));
}

bool is_among(std::size_t wanted, std::size_t number, std::size_t all) {
  return number == 0 || wanted >= all || number * wanted / all != (number - 1) * wanted / all;
}

Result<std::size_t> look_at_frames(Capture& capture, std::size_t most, Duration pause, const Look& look) {
  const std::uint64_t all = capture.frames().value_or(most);
  const std::uint64_t wanted = frames_to_look_at(capture, most);
  std::size_t looked_at = 0;
  Instant last{};
  for (std::uint64_t number = 0; looked_at < wanted; ++number) {
    auto frame = capture.next();
    if (!frame && frame.error().code == ErrorCode::kEndOfStream) break;
    if (!frame) return fail(frame.error());
    const bool due = capture.is_stream() ? looked_at == 0 || frame->metadata.captured_at - last >= pause
                                         : number >= looked_at * all / wanted;
    if (!due) continue;
    last = frame->metadata.captured_at;
    ++looked_at;
    const std::string said = look(std::move(*frame));
    if (!said.empty()) {
      fmt::print(stderr, "{}: picture {} of {}: {}\n", capture.name(), looked_at, wanted, said);
    }
  }
  if (looked_at == 0) {
    return fail(ErrorCode::kCorrupt, fmt::format("camera \"{}\" has no frame", capture.name()));
  }
  return looked_at;
}

}  // namespace copresence::calibrate
