#pragma once

// The command line of render_client as a checked, plain struct.
// Thread: values.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "render_client/renderer/renderer.h"
#include "render_client/viewpoint/viewer.h"

namespace copresence::client {

struct ClientSettings {
  std::vector<std::string> servers;  ///< HOST:PORT each
  std::string scene;                 ///< scene file; empty for none
  bool headless = false;
  std::string renderer = "auto";   ///< auto, gl, cpu
  int width = 1280, height = 720;  ///< of the view; even
  double fps = 30;                 ///< greatest number of views per second, headless
  /// Vertical field of view. Without it, it is viewpoint::kFovDegrees, or less if the view begins at a
  /// camera whose picture would not fill it.
  std::optional<double> fov_degrees;
  viewpoint::ViewChoice view;
  renderer::UnseenStyle unseen{.show = renderer::UnseenStyle::Show::kExtend};
  bool match_colors = true;  ///< live colour matching
  std::optional<std::uint64_t> frames;
  double stale_s = 3;      ///< seconds without a new frame after which a camera has faded from the view
  bool sync = false;       ///< views show frames of nearly one instant
  std::string screenshot;  ///< PNG file for the last view; empty for none
  std::string stats;       ///< JSON file; empty for none
};

/// Parses the command line. Fails with the exit code after --help, --version (0) or a mistake (2);
/// the terminal has the explanation already.
tl::expected<ClientSettings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::client
