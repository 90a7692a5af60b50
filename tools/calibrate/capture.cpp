#include "tools/calibrate/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "capture_server/sensor/source.h"
#include "common/command_line/values.h"
#include "common/tls/room_key.h"
#include "common/wire/frame_client.h"
#include "common/wire/host_port.h"
#include "common/wire/limited_log.h"
#include "render_client/decoding/frame_decoding.h"

namespace copresence::calibrate {
namespace {

constexpr std::chrono::milliseconds kConnectTimeout{2000};
constexpr int kMostLost = 90;  // Largest number of consecutive frames that may fail to decode.
// The frame timeout is longer than a camera needs after it is plugged in again.
constexpr std::chrono::seconds kFrameTimeout{10};

// Reads frames from a running capture_server.
class StreamSource : public sensor::FrameSource {
 public:
  StreamSource(const std::string& address, wire::FrameClient client, decoding::FrameDecoding decoding)
      : client_(std::move(client)), decoding_(std::move(decoding)) {
    client_.on_camera_status([this, address](const std::string& notice) {
      notice_ = notice;
      if (notice.empty()) return;
      log_.say(wire::LimitedLog::Topic::kNotice, wire::LimitedLog::Severity::kWarning,
               fmt::format("{}: {}", address, notice), std::chrono::steady_clock::now());
    });
    const StreamDescription& stream = client_.description();
    description_.name = stream.camera;
    description_.depth = description_.color = stream.model;
    description_.unit = stream.unit;
    description_.noise = stream.noise;
    description_.has_color = stream.has_color;
    description_.registered = true;
    description_.frames_per_second = stream.frames_per_second;
    if (stream.has_pose) description_.world_from_camera = stream.world_from_camera;
  }

  const sensor::SensorDescription& description() const override { return description_; }
  sensor::SourceCounters counters() const override { return counters_; }

  Result<RgbdFrame> next(std::stop_token stop) override {
    for (int lost = 0; lost < kMostLost; ++lost) {
      const auto received = client_.receive(stop, std::chrono::steady_clock::now() + kFrameTimeout);
      if (!received && received.error().code == ErrorCode::kTimeout) {
        return fail(ErrorCode::kTimeout,
                    notice_.empty() ? received.error().what : received.error().what + ": " + notice_);
      }
      if (!received) return fail(received.error());
      decoding::FrameDecoding::Durations durations;
      auto frame = decoding_.decode(received->frame, durations);
      if (!frame) {
        ++counters_.damaged;
        client_.request_keyframe();
        continue;
      }
      for (std::size_t i = 0; i < frame->depth.pixels().size(); ++i) {
        if (frame->state.data()[i] != DepthState::kMeasured) frame->depth.data()[i] = 0;
      }
      ++counters_.frames;
      return frame;
    }
    return fail(ErrorCode::kCorrupt,
                fmt::format("camera \"{}\" sends frames that do not decode", description_.name));
  }

 private:
  StreamSource(const StreamSource&) = delete;  // The client's callback refers to this object.
  StreamSource& operator=(const StreamSource&) = delete;

  wire::FrameClient client_;
  wire::LimitedLog log_{
      [](wire::LimitedLog::Severity, const std::string& line) { fmt::print(stderr, "{}\n", line); }};
  std::string notice_;  // The server's message about a camera that sends nothing; may be empty.
  decoding::FrameDecoding decoding_;
  sensor::SensorDescription description_;
  sensor::SourceCounters counters_;
};

/// `key_file` is empty for a server without a key.
Result<std::unique_ptr<sensor::FrameSource>> open_stream(const std::string& address,
                                                         const std::string& key_file) {
  std::optional<tls::RoomKey> key;
  if (!key_file.empty()) {
    const auto read = tls::read_key(key_file);
    if (!read) return fail(read.error());
    key = *read;
  }
  auto client = wire::FrameClient::connect(address, kConnectTimeout, {}, key ? &*key : nullptr);
  if (!client) return fail(client.error());
  auto decoding = decoding::FrameDecoding::open(client->description());
  if (!decoding) return fail(decoding.error());
  return std::make_unique<StreamSource>(address, std::move(*client), std::move(*decoding));
}

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
              NamedSource source{text.substr(0, equals), text.substr(equals + 1), is_stream, {}};
              if (const auto parsed = wire::parse_host_port(source.from); is_stream && !parsed) {
                throw CLI::ValidationError(flag, parsed.error().what);
              }
              const bool twice = std::any_of(sources.begin(), sources.end(), [&](const NamedSource& other) {
                return other.name == source.name;
              });
              if (twice) throw CLI::ValidationError(flag, "two sources are called " + source.name);
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
  const auto key = std::make_shared<std::string>();
  parser
      .add_option("--key", *key, "key file of the room, for servers with the same key [the scene file's key]")
      ->check(command_line::file_name())
      ->needs(options.stream);
  parser.parse_complete_callback([&sources, key, fewest, most] {
    for (NamedSource& source : sources) {
      if (source.is_stream) source.key = *key;
    }
    if (sources.size() >= fewest && sources.size() <= most) return;
    throw CLI::ValidationError("--recording and --stream", fmt::format("{} in all, but {} to {} are needed",
                                                                       sources.size(), fewest, most));
  });
  return options;
}

void remember_key(std::span<const NamedSource> sources, scene::Scene& scene) {
  for (const NamedSource& source : sources) {
    if (!source.key.empty()) scene.key = source.key;
  }
}

Result<Capture> Capture::open(const NamedSource& source, const scene::Scene* scene, Frames form) {
  const scene::Camera* known = scene ? scene->find(source.name) : nullptr;
  const std::string& key_file = source.key.empty() && scene ? scene->key : source.key;
  sensor::SourceSettings settings;
  settings.pace = sensor::SourceSettings::Pace::kFast;
  auto frames =
      source.is_stream ? open_stream(source.from, key_file) : sensor::open_source(source.from, settings);
  if (!frames) return fail(frames.error());
  sensor::SensorDescription sensor = (*frames)->description();
  if (known) {
    if (known->model.width != sensor.depth.width || known->model.height != sensor.depth.height) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("the scene file says that camera \"{}\" gives {}x{} pixels, but {} has {}x{}",
                              known->name, known->model.width, known->model.height, source.from,
                              sensor.depth.width, sensor.depth.height));
    }
    sensor.depth = known->model;
    if (known->color && !source.is_stream) {
      sensor.color = known->color->model;
      sensor.color_from_depth = known->color->color_from_depth;
      sensor.registered = false;
    }
    if (known->world_from_camera) sensor.world_from_camera = known->world_from_camera;
  }
  const bool passes_through = sensor.registered || form == Frames::kAsDelivered;
  auto registration = registration::Registration::open(
      {sensor.depth, sensor.has_color ? std::optional(sensor.color) : std::nullopt, sensor.color_from_depth,
       sensor.unit, passes_through, sensor.noise});
  if (!registration) return fail(registration.error());
  return Capture(source.name, source.is_stream, std::move(*frames), std::move(sensor),
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

Result<void> check_sources(std::span<const NamedSource> sources, const scene::Scene* scene) {
  for (const NamedSource& source : sources) {
    const auto capture = Capture::open(source, scene);
    if (!capture) return fail(capture.error());
  }
  return {};
}

std::size_t frames_to_read(const Capture& capture, std::size_t most) {
  const std::uint64_t all = capture.frames().value_or(most);
  return std::clamp<std::uint64_t>(most, 1, std::max<std::uint64_t>(all, 1));
}

bool is_sampled(std::size_t wanted, std::size_t number, std::size_t all) {
  return number == 0 || wanted >= all || number * wanted / all != (number - 1) * wanted / all;
}

Result<std::size_t> for_each_frame(Capture& capture, std::size_t most, Duration pause, const Visit& visit) {
  const std::uint64_t all = capture.frames().value_or(most);
  const std::uint64_t wanted = frames_to_read(capture, most);
  std::size_t visited = 0;
  Instant last{};
  for (std::uint64_t number = 0; visited < wanted; ++number) {
    auto frame = capture.next();
    if (!frame && frame.error().code == ErrorCode::kEndOfStream) break;
    if (!frame) return fail(frame.error());
    const bool due = capture.is_stream() ? visited == 0 || frame->metadata.captured_at - last >= pause
                                         : number >= visited * all / wanted;
    if (!due) continue;
    last = frame->metadata.captured_at;
    ++visited;
    const std::string said = visit(std::move(*frame));
    if (!said.empty()) {
      fmt::print(stderr, "{}: picture {} of {}: {}\n", capture.name(), visited, wanted, said);
    }
  }
  if (visited == 0) {
    return fail(ErrorCode::kCorrupt, fmt::format("camera \"{}\" has no frame", capture.name()));
  }
  return visited;
}

}  // namespace copresence::calibrate
