#include "capture_server/flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "common/depth/depth_codec.h"

namespace copresence::server {
namespace {

/// "NEAR:FAR" in metres.
std::string parse_range(const std::string& text, DepthRange& range) {
  const auto colon = text.find(':');
  double near = 0, far = 0;
  if (colon == std::string::npos || !CLI::detail::lexical_cast(text.substr(0, colon), near) ||
      !CLI::detail::lexical_cast(text.substr(colon + 1), far)) {
    return fmt::format("\"{}\" is not NEAR:FAR in metres, such as 0.4:5", text);
  }
  if (!(near >= 0.05 && near < far && far <= 65.0)) {
    return fmt::format("{}:{} m cannot be a range: NEAR must be at least 0.05 and below FAR, FAR at most 65",
                       near, far);
  }
  range = {near, far};
  return {};
}

/// "K/N" or "K/N:MS": turn K (from 1) of N, MS milliseconds each.
std::string parse_slot(const std::string& text, sensor::ProjectorSlot& slot) {
  const auto slash = text.find('/'), colon = std::min(text.find(':'), text.size());
  int turn = 0, count = 0, ms = static_cast<int>(slot.turn.count());
  if (slash == std::string::npos || slash > colon ||
      !CLI::detail::lexical_cast(text.substr(0, slash), turn) ||
      !CLI::detail::lexical_cast(text.substr(slash + 1, colon - slash - 1), count) ||
      (colon < text.size() && !CLI::detail::lexical_cast(text.substr(colon + 1), ms))) {
    return fmt::format("\"{}\" is not K/N or K/N:MS, such as 1/2 or 1/2:400", text);
  }
  using Slot = sensor::ProjectorSlot;
  const Slot wanted{turn - 1, count, std::chrono::milliseconds(ms)};
  if (!wanted.is_sensible()) {
    return fmt::format(
        "{} cannot be a turn: K goes from 1 to N, N to {}, MS from {}, and N turns take at most {} ms", text,
        Slot::kMost, Slot::kShortest.count(), Slot::kLongestRound.count());
  }
  slot = wanted;
  return {};
}

/// Of the codec and its parameters, whatever the camera.
std::string check_codec(const std::string& name) {
  const auto opened = depth::Encoder::open(name, {640, 480, DepthUnit::kMillimetre, {}});
  return opened ? std::string() : opened.error().what;
}

using hole_filling::Compute;
using Pace = sensor::SourceSettings::Pace;

std::map<std::string, hole_filling::Method> methods_by_name() {
  std::map<std::string, hole_filling::Method> methods;
  for (const auto method : hole_filling::kMethods) methods.emplace(hole_filling::name(method), method);
  return methods;
}

std::map<std::string, sensor::CameraControls::Mode> modes_by_name() {
  using Mode = sensor::CameraControls::Mode;
  return {{"auto", Mode::kAutomatic}, {"fixed", Mode::kFixed}};
}

}  // namespace

void add_flags(CLI::App& app, ServerSettings& settings) {
  auto* source =
      app.add_option("--source", settings.source,
                     "openni: (first camera), openni:URI (see --list), simulated:room?camera=N or a "
                     "recording FILE.oni");
  app.add_option("--listen", settings.listen, "address to accept clients on, HOST:PORT")
      ->capture_default_str();
  app.add_option("--name", settings.name,
                 "the camera's name [the recording's file name, cameraN when simulated, else camera]")
      ->check([](const std::string& name) {
        return name.empty() || name.size() > 64 ? std::string("a name has 1 to 64 characters")
                                                : std::string();
      });
  app.add_option("--codec", settings.codec,
                 "depth codec, with its parameters such as triangle:period=0.8, see docs/codecs.md")
      ->capture_default_str()
      ->check(CLI::Validator(check_codec, ""));
  auto* qp =
      app.add_option("--depth-qp", settings.rates.depth_qp, "constant quality of depth, 0 (lossless) to 51")
          ->capture_default_str()
          ->check(CLI::Range(0, 51));
  app.add_option("--depth-kbps", settings.rates.depth_kbps, "constant rate of all that depth costs, kbit/s")
      ->check(CLI::Range(50, 200000))
      ->excludes(qp);
  app.add_option("--color-kbps", settings.rates.color_kbps, "rate of colour, kbit/s")
      ->capture_default_str()
      ->check(CLI::Range(50, 200000));
  app.add_option("--hole-filling", settings.hole_filling, "off, median, bilateral or joint")
      ->default_str("joint")
      ->transform(CLI::Transformer(methods_by_name()).description(""));
  app.add_option_function<std::string>(
         "--range", [&](const std::string& text) { (void)parse_range(text, settings.range); },
         "depth that counts, NEAR:FAR in metres")
      ->default_str("0.4:5")
      ->check(CLI::Validator(
          [](const std::string& text) {
            DepthRange ignored;
            return parse_range(text, ignored);
          },
          ""));
  app.add_option("--compute", settings.compute,
                 "where holes are filled: auto (gl on a GPU, else cpu), gl or cpu")
      ->default_str("auto")
      ->transform(
          CLI::Transformer(std::map<std::string, Compute>{
                               {"auto", Compute::kAuto}, {"gl", Compute::kGl}, {"cpu", Compute::kCpu}})
              .description(""));
  app.add_option(
         "--exposure", settings.controls.exposure,
         "of a camera's colour: auto, or fixed at what auto found after two seconds [the camera's own way]")
      ->transform(CLI::Transformer(modes_by_name()).description(""));
  app.add_option("--white-balance", settings.controls.white_balance, "likewise: auto or fixed")
      ->transform(CLI::Transformer(modes_by_name()).description(""));
  app.add_option_function<std::string>(
         "--projector-slot",
         [&](const std::string& text) { (void)parse_slot(text, settings.controls.projector.emplace()); },
         "take turns with the projectors of this room's other cameras against interference: K/N[:MS], the "
         "Kth "
         "turn of N, MS milliseconds each [500]; frame rate falls below 30/N, see docs/cameras.md")
      ->check(CLI::Validator(
          [](const std::string& text) {
            sensor::ProjectorSlot ignored;
            return parse_slot(text, ignored);
          },
          ""));
  app.add_flag("--loop", settings.loop, "start a recording again at its end");
  app.add_option("--pace", settings.pace, "real: as recorded; fast: as fast as frames can be sent")
      ->default_str("real")
      ->transform(CLI::Transformer(std::map<std::string, Pace>{{"real", Pace::kReal}, {"fast", Pace::kFast}})
                      .description(""));
  app.add_option("--frames", settings.frames, "end after N captured frames")
      ->check(CLI::Range(1, 1'000'000'000));
  app.add_flag("--insecure", settings.insecure,
               "allow --listen beyond this machine: anyone who reaches the port sees the room, unencrypted");
  app.add_option("--scene", settings.scene, "scene file with this camera's pose and intrinsics, by --name");
  app.add_option(
      "--record", settings.record,
      "also record what the sensor gives to this .oni file, lossless in depth; a file that is there "
      "is not overwritten: FILE-2.oni is taken then");
  auto* list = app.add_flag("--list", settings.list, "list the devices that can be opened, and end")
                   ->configurable(false);
  source->excludes(list);
  app.add_option("--config", settings.config,
                 "settings file: this command line's flags as keys, FLAG = VALUE, where the command line "
                 "does not give them; "
                 "SIGHUP reads it again, see docs/video.md")
      ->configurable(false);
}

}  // namespace copresence::server
