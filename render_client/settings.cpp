#include "render_client/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "common/command_line/mistakes.h"
#include "common/command_line/values.h"
#include "common/version.h"
#include "render_client/renderer/renderer.h"
#include "render_client/viewpoint/opentrack_view.h"

namespace copresence::client {
namespace {

bool is_view(const std::string& view) {
  return view == "mouse" || opentrack_port(view) || (view.starts_with("path:") && view.size() > 5);
}

bool is_png_name(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return name.ends_with(".png");
}

constexpr const char* kKeys = R"(In the window:
  drag, left button             turn the view around what is in its middle
  drag, right or middle button  move sideways, up and down
  wheel                         move closer or farther
  R or Home                     back to the first camera's pose
  F11                           full screen, and back
  Escape                        end
The mouse, R and Home move the view with --view mouse only.)";

}  // namespace

std::optional<std::uint16_t> opentrack_port(const std::string& view) {
  constexpr std::string_view kTracker = "opentrack";
  if (!view.starts_with(kTracker)) return std::nullopt;
  if (view.size() == kTracker.size()) return viewpoint::OpentrackView::kPort;
  const std::string port = view.substr(kTracker.size() + 1);
  const bool is_port = view[kTracker.size()] == ':' && command_line::whole_number(1, 65535)(port).empty();
  return is_port ? std::optional(static_cast<std::uint16_t>(std::stoi(port))) : std::nullopt;
}

tl::expected<ClientSettings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  ClientSettings settings;
  CLI::App app{"Shows the room that one or more capture_servers stream, from a viewpoint of your own.",
               "render_client"};
  app.footer(kKeys);
  app.set_version_flag("--version", std::string("render_client ") + kVersion);

  auto* connect = app.add_option("--connect", settings.servers,
                                 fmt::format("a capture_server, HOST:PORT; once for each camera, at most {}",
                                             renderer::kMostCameras))
                      ->check(some("HOST:PORT"));
  app.add_option(
         "--scene", settings.scene,
         "scene file: the cameras to connect to (unless --connect says), their poses, intrinsics, colours")
      ->check(file_name());
  app.add_flag("--headless", settings.headless, "no window");
  app.add_option("--renderer", settings.renderer, "auto (gl on a GPU, else cpu), gl or cpu")
      ->capture_default_str()
      ->check(one_of({"auto", "gl", "cpu"}));
  add_size(app, "--size", settings.width, settings.height, {16, 8192},
           "size of the view, WIDTHxHEIGHT in pixels");
  app.add_option("--fps", settings.fps, "views a second at most, headless")
      ->capture_default_str()
      ->check(number(0.1, 1000));
  app.add_option("--fov", settings.fov_degrees, "vertical field of view, degrees")
      ->capture_default_str()
      ->check(number(5, 150));
  app.add_flag("--sync", settings.sync,
               "show frames of nearest instants together; a frame waits for half a period at most");
  app.add_option(
         "--stale", settings.stale_s,
         "seconds after which a camera that sends no frame is gone from the view; it fades from a third of "
         "them on")
      ->capture_default_str()
      ->check(number(0.1, 86'400));
  app.add_option(
         "--view", settings.view,
         "mouse (default in a window), path:FILE (lines \"view x y z look_x look_y look_z\", metres) or "
         "opentrack[:PORT] (UDP, port 4242 unless said); without a window the default is the first camera's "
         "pose")
      ->check(must_be("mouse, path:FILE or opentrack[:PORT]", is_view));
  app.add_option_function<std::string>(
         "--color-matching", [&](const std::string& choice) { settings.match_colors = choice == "live"; },
         "live: the colours of cameras whose pose is known are matched to the first one's where they "
         "overlap, unless "
         "the scene file gives a camera's color_matching; off: as they come [live]")
      ->check(one_of({"live", "off"}));
  app.add_option(
         "--frames", settings.frames,
         "end after N views, counted from the first that shows every camera in matched colours, but for "
         "cameras that cannot be shown; without a window the program also ends when every camera has ended")
      ->check(whole_number<std::uint64_t>(1, 1'000'000'000));
  app.add_option("--screenshot", settings.screenshot, "write the last view to this PNG file")
      ->check(writable_file())
      ->check(must_be("a PNG file's name; it must end in .png", is_png_name));
  app.add_option("--stats", settings.stats, "write statistics to this JSON file at the end")
      ->check(writable_file());

  try {
    app.parse(argc, argv);
    if (connect->empty() && settings.scene.empty()) {
      throw CLI::RequiredError("--connect HOST:PORT or --scene FILE");
    }
    if (settings.servers.size() > renderer::kMostCameras) {
      throw CLI::ValidationError("--connect", fmt::format("{} cameras are given; one view shows at most {}",
                                                          settings.servers.size(), renderer::kMostCameras));
    }
    if (settings.headless && settings.view == "mouse") {
      throw CLI::ValidationError("--view mouse",
                                 "needs a window; with --headless choose path:FILE or opentrack");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(explain(app, error));
  }
  return settings;
}

}  // namespace copresence::client
