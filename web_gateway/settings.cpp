#include "web_gateway/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "common/command_line/parse_errors.h"
#include "common/command_line/values.h"
#include "common/version.h"

namespace copresence::gateway {

tl::expected<GatewaySettings, int> read_command_line(int argc, const char* const* argv) {
  using namespace command_line;
  GatewaySettings settings;
  CLI::App app{
      "Shows the scene that one or more capture_servers stream in web browsers. It serves the page and "
      "forwards the encoded frames unchanged.",
      "web_gateway"};
  app.set_version_flag("--version", std::string("web_gateway ") + kVersion);
  auto* connect =
      app.add_option(
             "--connect", settings.servers,
             fmt::format(
                 "address of a capture_server, HOST:PORT; give it once for each camera, at most {} times",
                 kMostCameras))
          ->check(some("HOST:PORT"));
  app.add_option(
         "--scene", settings.scene,
         "scene file with the cameras' addresses (unless --connect gives them), intrinsics, and the poses "
         "that their servers do not know")
      ->check(file_name());
  app.add_option("--key", settings.key,
                 "file with the key of the room's capture servers, unless the scene file names it")
      ->check(file_name());
  app.add_option("--listen", settings.listen,
                 "address for browsers, HOST:PORT; beyond this machine it needs --token or --open")
      ->capture_default_str()
      ->check(some("HOST:PORT"));
  auto* certificate =
      app.add_option(
             "--certificate", settings.certificate,
             "serve HTTPS with this certificate (PEM, with its chain); browsers on other machines show "
             "the room over HTTPS only, from here or from a web server before it")
          ->check(existing_file());
  auto* private_key =
      app.add_option("--private-key", settings.private_key, "private key of --certificate (PEM)")
          ->check(existing_file());
  auto* token = app.add_option("--token", settings.token,
                               "file with the token that viewers need; it stands in the link: "
                               "http://HOST:PORT/#token=...")
                    ->check(file_name());
  auto* open = app.add_flag("--open", settings.open, "everybody who reaches the address may watch");
  app.add_option("--max-viewers", settings.max_viewers, "greatest number of viewers at a time")
      ->capture_default_str()
      ->check(whole_number<std::size_t>(1, 10'000));
  auto* make_token = app.add_option("--make-token", settings.make_token,
                                    "write a new random token to this file, for --token, and end")
                         ->check(file_name());
  try {
    app.parse(argc, argv);
    if (!make_token->empty()) return settings;
    if (connect->empty() && settings.scene.empty()) {
      throw CLI::RequiredError("--connect HOST:PORT or --scene FILE");
    }
    if (settings.servers.size() > kMostCameras) {
      throw CLI::ValidationError("--connect", fmt::format("{} cameras are given; a room has at most {}",
                                                          settings.servers.size(), kMostCameras));
    }
    if (certificate->empty() != private_key->empty()) {
      throw CLI::ValidationError(
          certificate->empty() ? "--private-key" : "--certificate",
          fmt::format("needs {} too", certificate->empty() ? "--certificate" : "--private-key"));
    }
    if (!token->empty() && !open->empty()) {
      throw CLI::ValidationError("--open", "cannot be combined with --token");
    }
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(report_parse_error(app, error));
  }
  return settings;
}

}  // namespace copresence::gateway
