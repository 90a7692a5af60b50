#pragma once

// The command line of web_gateway. Thread: the main thread.

#include <cstddef>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace copresence::gateway {

struct GatewaySettings {
  std::vector<std::string> servers;  ///< HOST:PORT of each camera's capture_server.
  std::string scene;                 ///< Path of a scene file that names the servers, or empty.
  std::string key;                   ///< Path of the capture servers' room key, or empty.
  std::string listen = "127.0.0.1:8080";
  std::string certificate, private_key;  ///< Paths of PEM files for HTTPS; both empty for HTTP.
  std::string token;                     ///< Path of the file with the viewers' token, or empty.
  bool open = false;                     ///< Whether everybody may watch without a token.
  std::size_t max_viewers = 50;
  std::string make_token;  ///< Path of a token file to make; the program then ends.
};

/// A room has at most this many cameras, as in render_client.
inline constexpr std::size_t kMostCameras = 32;

/// Parses the command line. After --help and --version it fails with the exit code 0, and after a
/// mistake with 2. It has then printed the help or an error message.
tl::expected<GatewaySettings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::gateway
