#include "render_client/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "common/version.h"

namespace copresence::client {
namespace {

/// "WxH" in pixels.
std::string parse_size(const std::string& text, int& width, int& height) {
  const auto x = text.find('x');
  if (x == std::string::npos || !CLI::detail::lexical_cast(text.substr(0, x), width) ||
      !CLI::detail::lexical_cast(text.substr(x + 1), height)) {
    return fmt::format("\"{}\" is not WIDTHxHEIGHT in pixels, such as 1280x720", text);
  }
  if (width < 16 || height < 16 || width > 8192 || height > 8192 || width % 2 || height % 2) {
    return fmt::format("{} cannot be a view's size: width and height must be even, from 16 to 8192", text);
  }
  return {};
}

std::string check_view(const std::string& view) {
  if (view == "mouse" || view == "opentrack" || (view.starts_with("path:") && view.size() > 5)) return {};
  return fmt::format("there is no view \"{}\"; there are mouse, path:FILE and opentrack", view);
}

}  // namespace

tl::expected<ClientSettings, int> read_command_line(int argc, const char* const* argv) {
  ClientSettings settings;
  CLI::App app{"Shows the room that one or more capture_servers stream, from a viewpoint of your own.",
               "render_client"};
  app.set_version_flag("--version", std::string("render_client ") + kVersion);

  auto* connect =
      app.add_option("--connect", settings.servers, "a capture_server, HOST:PORT; once for each camera");
  app.add_option(
      "--scene", settings.scene,
      "scene file: the cameras to connect to (unless --connect says), their poses, intrinsics, colours");
  app.add_flag("--headless", settings.headless, "no window");
  app.add_option("--renderer", settings.renderer, "auto (gl on a GPU, else cpu), gl or cpu")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "gl", "cpu"}));
  app.add_option_function<std::string>(
         "--size", [&](const std::string& text) { (void)parse_size(text, settings.width, settings.height); },
         "size of the view, WIDTHxHEIGHT in pixels [1280x720]")
      ->check(CLI::Validator(
          [](const std::string& text) {
            int width = 0, height = 0;
            return parse_size(text, width, height);
          },
          ""));
  app.add_option("--fps", settings.fps, "views a second at most, headless")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 1000.0));
  app.add_option("--fov", settings.fov_degrees, "vertical field of view, degrees")
      ->capture_default_str()
      ->check(CLI::Range(5.0, 150.0));
  app.add_flag("--sync", settings.sync,
               "show frames of nearest instants together; a frame waits for half a period at most");
  app.add_option(
         "--view", settings.view,
         "mouse (default in a window), path:FILE (lines \"view x y z look_x look_y look_z\", metres) or "
         "opentrack (UDP, port 4242); without a window the default is the first camera's pose")
      ->check(CLI::Validator(check_view, ""));
  app.add_option_function<std::string>(
         "--color-matching", [&](const std::string& choice) { settings.match_colors = choice == "live"; },
         "live: the colours of cameras whose pose is known are matched to the first one's where they "
         "overlap, unless "
         "the scene file gives a camera's color_matching; off: as they come [live]")
      ->check(CLI::IsMember({"live", "off"}));
  app.add_option("--frames", settings.frames,
                 "end after N views, counted from the first that shows every camera")
      ->check(CLI::PositiveNumber);
  app.add_option("--screenshot", settings.screenshot, "write the last view to this PNG file");
  app.add_option("--stats", settings.stats, "write statistics to this JSON file at the end");

  try {
    app.parse(argc, argv);
    if (connect->empty() && settings.scene.empty()) {
      throw CLI::RequiredError("--connect HOST:PORT or --scene FILE");
    }
    if (settings.headless && settings.view == "mouse") {
      throw CLI::ValidationError("--view mouse",
                                 "needs a window; with --headless choose path:FILE or opentrack");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(app.exit(error) == 0 ? 0 : 2);
  }
  return settings;
}

}  // namespace copresence::client
