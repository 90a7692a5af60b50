#pragma once

// The command line of render_client as one checked, plain struct.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"

namespace copresence::client {

struct ClientSettings {
  std::vector<std::string> servers;  ///< HOST:PORT each
  std::string scene;                 ///< scene file; empty for none
  bool headless = false;
  std::string renderer = "auto";   ///< auto, gl, cpu
  int width = 1280, height = 720;  ///< of the view; even
  double fps = 30;                 ///< views a second at most, headless
  double fov_degrees = 50;         ///< vertical
  std::string view;                ///< mouse, path:FILE or opentrack[:PORT]; empty for the default
  bool match_colors = true;        ///< the cameras' colours to the first one's
  std::optional<std::uint64_t> frames;
  double stale_s = 3;      ///< a camera without a new frame is gone from the view after so many seconds
  bool sync = false;       ///< views of frames of nearest instants
  std::string screenshot;  ///< PNG of the last view; empty for none
  std::string stats;       ///< JSON; empty for none
};

/// The UDP port of a `view` that is opentrack[:PORT]; nothing where it is another one.
std::optional<std::uint16_t> opentrack_port(const std::string& view);

/// What the command line asks for: settings to run with, or an exit code after --help, --version or a mistake
/// (0 or 2, already explained on the terminal).
tl::expected<ClientSettings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::client
