#include "render_client/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <functional>

#include "common/command_line/parse_errors.h"
#include "common/command_line/values.h"
#include "common/version.h"
#include "render_client/display/controls.h"
#include "render_client/renderer/renderer.h"

namespace copresence::client {
namespace {

/// Returns a function that checks the end of a file's name.
std::function<bool(const std::string&)> has_extension(std::string extension) {
  return [extension = std::move(extension)](std::string name) {
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    return name.ends_with(extension);
  };
}

renderer::UnseenStyle::Show unseen_choice(const std::string& choice) {
  using Show = renderer::UnseenStyle::Show;
  if (choice == "extend") return Show::kExtend;
  return choice == "dim" ? Show::kDim : Show::kBlack;
}

std::optional<Rgb8> parse_color(const std::string& text) {
  unsigned value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != 6 || problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return Rgb8{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
              static_cast<std::uint8_t>(value)};
}

std::string help_on_controls() {
  std::string text = "In the window:\n";
  for (const display::Control& control : display::controls())
    text += fmt::format("  {:<36} {}\n", control.input, control.effect);
  return text + "The mouse, R and Home move the view with --view mouse only.";
}

}  // namespace

tl::expected<ClientSettings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  using Kind = viewpoint::ViewChoice::Kind;
  ClientSettings settings;
  CLI::App app{"Shows the scene that one or more capture_servers stream, from a viewpoint of your own.",
               "render_client"};
  app.footer(help_on_controls());
  app.set_version_flag("--version", std::string("render_client ") + kVersion);

  auto* connect =
      app.add_option(
             "--connect", settings.servers,
             fmt::format(
                 "address of a capture_server, HOST:PORT; give it once for each camera, at most {} times",
                 renderer::kMostCameras))
          ->check(some("HOST:PORT"));
  app.add_option("--scene", settings.scene,
                 "scene file with the addresses (unless --connect gives them), poses, intrinsics and colours "
                 "of cameras")
      ->check(file_name());
  app.add_option(
         "--key", settings.key,
         "key file of the room, for servers with the same key: encrypts the streams [the scene file's "
         "key]")
      ->check(file_name());
  auto* replay =
      app.add_option("--replay", settings.replay, "show this session recording (.mkv) instead of servers")
          ->check(existing_file())
          ->excludes(connect);
  app.add_option("--record", settings.record,
                 "record the session to this file (.mkv): what the servers send, without loss; if it exists, "
                 "name-2.mkv and so on")
      ->check(must_be("a Matroska file's name; it must end in .mkv", has_extension(".mkv")))
      ->excludes(replay);
  app.add_flag("--headless", settings.headless, "no window");
  app.add_option("--renderer", settings.renderer, "auto (gl on a GPU, else cpu), gl or cpu")
      ->capture_default_str()
      ->check(one_of({"auto", "gl", "cpu"}));
  add_size(app, "--size", settings.width, settings.height, {16, 8192},
           "size of the view, WIDTHxHEIGHT in pixels");
  app.add_option("--fps", settings.fps, "greatest number of views per second, headless")
      ->capture_default_str()
      ->check(number(0.1, 1000));
  app.add_option("--fov", settings.fov_degrees,
                 "vertical field of view, degrees [50; less where the view begins at a camera whose picture "
                 "would not fill it]")
      ->check(number(5, 150));
  app.add_flag(
      "--sync", settings.sync,
      "show frames that were captured at nearly the same instant; a frame waits for half a period at most");
  app.add_option("--stale", settings.stale_s,
                 "seconds without a new frame after which a camera is gone from the view; it fades from a "
                 "third of this "
                 "time on")
      ->capture_default_str()
      ->check(number(0.1, 86'400));
  app.add_option_function<std::string>(
         "--unseen", [&](const std::string& choice) { settings.unseen.show = unseen_choice(choice); },
         "what no camera has seen: extend the farther surfaces around it, dim them, or leave it black "
         "[extend]")
      ->check(one_of({"extend", "dim", "black"}));
  app.add_option_function<std::string>(
         "--background", [&](const std::string& text) { settings.unseen.background = *parse_color(text); },
         "colour where there is nothing to show, RRGGBB in hexadecimal digits [000000]")
      ->check(must_be("six hexadecimal digits, RRGGBB",
                      [](const std::string& text) { return parse_color(text).has_value(); }));
  app.add_option_function<std::string>(
         "--stereo", [&](const std::string& name) { settings.stereo.mode = *display::parse_stereo(name); },
         "pictures for two eyes, in a window, in --screenshot and in --film: none, side (left and right "
         "half), "
         "top (upper and lower half), anaglyph (red-cyan glasses) or rows (every other row) [none]")
      ->check(one_of({"none", "side", "top", "anaglyph", "rows"}));
  app.add_option("--eye-distance", settings.stereo.eye_distance_m,
                 "distance between the eyes, metres; a negative distance exchanges the eyes")
      ->capture_default_str()
      ->check(number(-1, 1));
  app.add_option("--screen-distance", settings.stereo.screen_distance_m,
                 "distance from the eyes, in metres, of the surfaces that appear in the plane of the screen")
      ->capture_default_str()
      ->check(number(0.1, 1000));
  std::optional<viewpoint::ViewChoice> view;
  app.add_option_function<std::string>(
         "--view", [&](const std::string& text) { view = viewpoint::parse_view(text); },
         "mouse (default in a window), path:FILE (lines \"view x y z look_x look_y look_z\", metres) or "
         "opentrack[:PORT] (UDP, default port 4242); headless, the default is the pose of the first camera")
      ->check(must_be("mouse, path:FILE or opentrack[:PORT]",
                      [](const std::string& text) { return viewpoint::parse_view(text).has_value(); }));
  app.add_option_function<std::string>(
         "--color-matching", [&](const std::string& choice) { settings.match_colors = choice == "live"; },
         "live: match the colours of cameras with a known pose to those of the first camera, unless the "
         "scene "
         "file gives a camera's color_matching; off: show colours as they come [live]")
      ->check(one_of({"live", "off"}));
  app.add_option("--frames", settings.frames,
                 "end after N views, counted from the first one that shows every available camera in matched "
                 "colours; "
                 "headless, the program also ends when every camera has ended")
      ->check(whole_number<std::uint64_t>(1, 1'000'000'000));
  app.add_option("--film", settings.film,
                 "headless: write the counted views as a film, to a file (.mkv) or as numbered pictures to a "
                 "folder")
      ->check(some("a file's or folder's name"));
  app.add_option("--screenshot", settings.screenshot, "write the last view to this PNG file")
      ->check(writable_file())
      ->check(must_be("a PNG file's name; it must end in .png", has_extension(".png")));
  app.add_option("--stats", settings.stats, "write statistics to this JSON file at the end")
      ->check(writable_file());

  try {
    app.parse(argc, argv);
    if (connect->empty() && settings.scene.empty() && settings.replay.empty()) {
      throw CLI::RequiredError("--connect HOST:PORT, --scene FILE or --replay FILE.mkv");
    }
    if (settings.servers.size() > renderer::kMostCameras) {
      throw CLI::ValidationError("--connect", fmt::format("{} cameras are given; one view shows at most {}",
                                                          settings.servers.size(), renderer::kMostCameras));
    }
    if (!settings.film.empty() && !settings.headless)
      throw CLI::ValidationError("--film", "needs --headless");
    if (settings.headless && view && view->kind == Kind::kMouse) {
      throw CLI::ValidationError("--view mouse",
                                 "needs a window; with --headless choose path:FILE or opentrack");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(report_parse_error(app, error));
  }
  const auto unnamed = settings.headless ? Kind::kFixed : Kind::kMouse;
  settings.view = view.value_or(viewpoint::ViewChoice{unnamed, {}});
  return settings;
}

}  // namespace copresence::client
