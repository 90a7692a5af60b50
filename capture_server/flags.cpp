#include "capture_server/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/command_line/values.h"
#include "common/depth/depth_codec.h"

namespace copresence::server {
namespace {

// The latest time that --start-at accepts, in Unix seconds: the year 3000. Larger numbers are
// probably milliseconds.
constexpr double kLatestStart = 32'503'680'000;

/// Parses "K/N" or "K/N:MS": time slot K (from 1) of N slots of MS milliseconds each.
std::string parse_slot(const std::string& text, sensor::ProjectorSlot& slot) {
  const auto slash = text.find('/'), colon = std::min(text.find(':'), text.size());
  int index = 0, count = 0, ms = static_cast<int>(slot.length.count());
  if (slash == std::string::npos || slash > colon ||
      !CLI::detail::lexical_cast(text.substr(0, slash), index) ||
      !CLI::detail::lexical_cast(text.substr(slash + 1, colon - slash - 1), count) ||
      (colon < text.size() && !CLI::detail::lexical_cast(text.substr(colon + 1), ms))) {
    return fmt::format("\"{}\" is not K/N or K/N:MS, such as 1/2 or 1/2:400", text);
  }
  using Slot = sensor::ProjectorSlot;
  const Slot wanted{index - 1, count, std::chrono::milliseconds(ms)};
  if (!wanted.is_sensible()) {
    return fmt::format(
        "{} is no time slot: K goes from 1 to N, N to {}, MS from {}, and N slots take at most {} ms", text,
        Slot::kMost, Slot::kShortest.count(), Slot::kLongestRound.count());
  }
  slot = wanted;
  return {};
}

/// Checks the codec's name and parameters for a typical camera.
std::string check_codec(const std::string& name) {
  const auto opened = depth::Encoder::open(name, {640, 480, DepthUnit::kMillimetre, {}});
  return opened ? std::string() : opened.error().what;
}

using command_line::add_depth_range;
using command_line::file_name;
using command_line::must_be;
using command_line::number;
using command_line::one_of;
using command_line::some;
using command_line::whole_number;
using hole_filling::Compute;
using Filter = temporal_filter::Mode;
using Pace = sensor::SourceSettings::Pace;

std::vector<std::pair<std::string, hole_filling::Method>> methods_by_name() {
  std::vector<std::pair<std::string, hole_filling::Method>> methods;
  methods.reserve(std::size(hole_filling::kMethods));
  for (const auto method : hole_filling::kMethods) methods.emplace_back(hole_filling::name(method), method);
  return methods;
}

CLI::Validator automatic_or_fixed() {
  using Mode = sensor::CameraControls::Mode;
  return one_of<Mode>({{"auto", Mode::kAutomatic}, {"fixed", Mode::kFixed}});
}

}  // namespace

void add_flags(CLI::App& app, ServerSettings& settings) {
  auto* source =
      app.add_option("--source", settings.source,
                     "openni: (first camera), openni:URI (see --list), simulated:room?camera=N or a "
                     "recording FILE.oni [the scene file's source]")
          ->check(some("openni:, openni:URI, simulated:room?camera=N or FILE.oni"));
  app.add_option("--listen", settings.listen,
                 "address to accept clients on, HOST:PORT [the scene file's address, else]")
      ->capture_default_str()
      ->check(some("HOST:PORT"));
  app.add_option("--name", settings.name,
                 "the camera's name [the recording's file name, cameraN when simulated, else camera]")
      ->check(must_be("a name of 1 to 64 characters",
                      [](const std::string& name) { return !name.empty() && name.size() <= 64; }));
  app.add_option("--codec", settings.codec,
                 "depth codec, with its parameters such as triangle:period=0.8, see docs/internals/codecs.md")
      ->capture_default_str()
      ->check(CLI::Validator(check_codec, ""));
  auto* qp =
      app.add_option("--depth-qp", settings.encoder.depth_qp, "constant quality of depth, 0 (lossless) to 51")
          ->capture_default_str()
          ->check(whole_number(0, 51));
  app.add_option("--depth-kbps", settings.encoder.depth_kbps,
                 "constant bitrate of depth with all its side data, kbit/s")
      ->check(whole_number(50, 200000))
      ->excludes(qp);
  app.add_option("--color-kbps", settings.encoder.color_kbps, "bitrate of colour, kbit/s")
      ->capture_default_str()
      ->check(whole_number(50, 200000));
  app.add_option("--hole-filling", settings.hole_filling, "off, median, bilateral or joint")
      ->default_str("joint")
      ->transform(one_of(methods_by_name()));
  app.add_option(
         "--temporal-filter", settings.temporal_filter,
         "auto: keep depth and colour of static surfaces still before coding, except with --depth-qp 0 "
         "and while the camera moves; off: never")
      ->default_str("auto")
      ->transform(one_of<Filter>({{"auto", Filter::kAuto}, {"off", Filter::kOff}}));
  add_depth_range(app, "--range", settings.range, "depth range to keep, NEAR:FAR in metres");
  app.add_option("--compute", settings.compute,
                 "where holes are filled: auto (gl on a GPU, else cpu), gl or cpu")
      ->default_str("auto")
      ->transform(one_of<Compute>({{"auto", Compute::kAuto}, {"gl", Compute::kGl}, {"cpu", Compute::kCpu}}));
  app.add_option("--exposure", settings.controls.exposure,
                 "exposure of a camera's colour: auto, or fixed at its automatic value after two seconds "
                 "[the camera's default]")
      ->transform(automatic_or_fixed());
  app.add_option("--white-balance", settings.controls.white_balance,
                 "white balance of a camera's colour: auto or fixed, as --exposure")
      ->transform(automatic_or_fixed());
  app.add_option_function<std::string>(
         "--projector-slot",
         [&](const std::string& text) { (void)parse_slot(text, settings.controls.projector.emplace()); },
         "take turns with the projectors of the room's other cameras against interference: K/N[:MS] is the "
         "Kth of N time slots, MS milliseconds each [500]; the frame rate falls below 30/N, see "
         "docs/guide/cameras.md")
      ->check(CLI::Validator(
          [](const std::string& text) {
            sensor::ProjectorSlot ignored;
            return parse_slot(text, ignored);
          },
          ""));
  app.add_flag("--loop", settings.loop, "start a recording again at its end");
  app.add_option("--pace", settings.pace, "real: as recorded; fast: as fast as frames can be sent")
      ->default_str("real")
      ->transform(one_of<Pace>({{"real", Pace::kReal}, {"fast", Pace::kFast}}));
  app.add_option("--start-at", settings.start_at,
                 "Unix time in seconds at which a recording begins, to play on several servers in sync "
                 "[the machine's next fifth of a second]")
      ->check(number(0, kLatestStart));
  app.add_option("--frames", settings.frames, "end after N captured frames")
      ->check(whole_number<std::uint64_t>(1, 1'000'000'000));
  auto* key =
      app.add_option("--key", settings.key,
                     "key file of the room: encrypts the stream, and admits only clients with the same "
                     "key; needed to listen beyond this machine [the scene file's key]")
          ->check(file_name());
  app.add_flag("--insecure", settings.insecure,
               "allow --listen beyond this machine without a key: anyone who reaches the port sees the room, "
               "unencrypted")
      ->excludes(key);
  app.add_option("--scene", settings.scene,
                 "scene file with the room's key and this camera's pose and intrinsics, by --name")
      ->check(file_name());
  app.add_option("--record", settings.record,
                 "also record the sensor's frames to this .oni file, lossless in depth; if it exists, "
                 "FILE-2.oni is created instead, then FILE-3.oni and so on")
      ->check(file_name());
  auto* list = app.add_flag("--list", settings.list, "list the devices that can be opened, and end")
                   ->configurable(false);
  auto* make_key = app.add_option("--make-key", settings.make_key,
                                  "write a new random key to this file, readable by you only, and end; an "
                                  "existing file is never overwritten")
                       ->configurable(false)
                       ->check(file_name());
  source->excludes(list)->excludes(make_key);
  app.add_option("--config", settings.config,
                 "settings file with the flags as keys, FLAG = VALUE; the command line takes precedence; "
                 "SIGHUP reads it again, see docs/guide/quality_and_bandwidth.md")
      ->configurable(false)
      ->check(file_name());
}

}  // namespace copresence::server
