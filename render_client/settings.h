#pragma once

// The command line of render_client as a plain struct with checked values.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "render_client/display/stereo.h"
#include "render_client/renderer/renderer.h"
#include "render_client/viewpoint/viewer.h"

namespace copresence::client {

struct ClientSettings {
  std::vector<std::string> servers;  ///< Addresses, HOST:PORT.
  std::string scene;                 ///< Path of the scene file, or empty.
  std::string key;                   ///< Path of the room's key file, or empty.
  std::string replay;                ///< Path of the session recording to replay, or empty.
  std::string record;                ///< Path of the session recording to write, or empty.
  bool headless = false;
  std::string renderer = "auto";   ///< auto, gl or cpu.
  int width = 1280, height = 720;  ///< Size of the view; even numbers of pixels.
  double fps = 30;                 ///< Greatest number of views per second without a window.
  /// Vertical field of view, as in viewpoint::ViewFormat.
  std::optional<double> fov_degrees;
  display::Stereo stereo;
  viewpoint::ViewChoice view;
  renderer::UnseenStyle unseen{.show = renderer::UnseenStyle::Show::kExtend};
  bool match_colors = true;
  std::optional<std::uint64_t> frames;
  double stale_s = 3;      ///< A camera disappears after this many seconds without a new frame.
  bool sync = false;       ///< Whether a view shows frames of nearly the same instant.
  std::string film;        ///< Path of the film of the views, or empty.
  std::string screenshot;  ///< Path of the PNG file for the last view, or empty.
  std::string stats;       ///< Path of the JSON file for statistics, or empty.
};

/// Parses the command line. After --help and --version it fails with the exit code 0, and after a
/// mistake with 2. It has then printed the help or an error message.
tl::expected<ClientSettings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::client
