#include "capture_server/drivers/contract/simulated_uri.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace copresence::drivers {
namespace {

constexpr const char* kOptions = "camera=N, cameras=N, seed=N, marker=on, control=FILE or projectors=FILE";

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  return problem == std::errc() && end == text.data() + text.size();
}

// Cuts `text` at the first `separator`. Returns the part before it and keeps the rest in `text`.
std::string_view take_until(char separator, std::string_view& text) {
  const auto at = text.find(separator);
  const std::string_view before = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
  return before;
}

bool read_option(std::string_view key, std::string_view value, SimulatedUri& into) {
  if (key == "camera") return read_number(value, into.camera);
  if (key == "cameras") return read_number(value, into.cameras);
  if (key == "seed") return read_number(value, into.seed);
  if (key == "control" || key == "projectors") {
    (key == "control" ? into.control : into.projectors) = value;
    return !value.empty();
  }
  into.marker = value == "on";
  return key == "marker" && (value == "on" || value == "off");
}

}  // namespace

Result<SimulatedUri> parse_simulated_uri(const std::string& uri) {
  if (!uri.starts_with(kSimulatedPrefix)) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: a simulated camera is written simulated:WORLD?camera=N", uri));
  }
  SimulatedUri parsed;
  std::string_view rest(uri);
  rest.remove_prefix(std::min(rest.size(), std::string_view(kSimulatedPrefix).size()));
  parsed.world = take_until('?', rest);
  if (std::find(kSimulatedWorlds.begin(), kSimulatedWorlds.end(), parsed.world) == kSimulatedWorlds.end()) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: there is no world \"{}\"; there are {}", uri,
                                                 parsed.world, fmt::join(kSimulatedWorlds, ", ")));
  }
  while (!rest.empty()) {
    const std::string_view option = take_until('&', rest);
    std::string_view value = option;
    const std::string_view key = take_until('=', value);
    if (key.size() == option.size() || !read_option(key, value, parsed)) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: \"{}\" is none of {}", uri, option, kOptions));
    }
  }
  if (parsed.camera < 0 || parsed.camera >= kMostSimulatedCameras || parsed.cameras < 1 ||
      parsed.cameras > kMostSimulatedCameras) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: camera goes from 0 to {}, cameras from 1 to {}", uri,
                                                 kMostSimulatedCameras - 1, kMostSimulatedCameras));
  }
  parsed.cameras = std::max(parsed.cameras, parsed.camera + 1);
  return parsed;
}

std::string simulated_cameras() {
  return fmt::format("{}WORLD?camera=N, N from 0 to {}, WORLD one of {}", kSimulatedPrefix,
                     kMostSimulatedCameras - 1, fmt::join(kSimulatedWorlds, ", "));
}

}  // namespace copresence::drivers
