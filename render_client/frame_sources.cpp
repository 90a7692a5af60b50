#include "render_client/frame_sources.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/wire/host_port.h"
#include "render_client/renderer/renderer.h"
#include "render_client/session/session_file.h"
#include "render_client/stream/frame_source.h"

namespace copresence::client {
namespace {

constexpr std::chrono::milliseconds kConnectTimeout{2000};

Result<std::vector<std::string>> addresses(const ClientSettings& settings, const scene::Scene* scene) {
  std::vector<std::string> out = settings.servers;
  if (out.empty()) {
    for (const scene::Camera& camera : scene->cameras) {
      if (!camera.address.empty()) out.push_back(camera.address);
    }
  }
  if (out.empty()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: no camera has an \"address\" to connect to", settings.scene));
  }
  for (const std::string& address : out) {
    if (const auto understood = wire::parse_host_port(address); !understood) return fail(understood.error());
  }
  if (out.size() > renderer::kMostCameras) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: {} cameras have an \"address\", and one view shows at most {}; name those to "
                    "show with --connect",
                    settings.scene, out.size(), renderer::kMostCameras));
  }
  return out;
}

/// Reads the room's key. Empty if neither the command line nor the scene file names one.
Result<std::optional<tls::RoomKey>> room_key(const ClientSettings& settings, const scene::Scene* scene) {
  const std::string path = settings.key.empty() && scene ? scene->key : settings.key;
  if (path.empty()) return std::optional<tls::RoomKey>();
  const auto key = tls::read_key(path);
  if (!key) return fail(key.error());
  return std::optional(*key);
}

Result<FrameSources> open_replay(const std::string& path) {
  auto file = session::SessionFile::open(path);
  if (!file) return fail(file.error());
  for (const std::string& remark : file->remarks()) spdlog::warn("{}", remark);
  const std::size_t cameras = file->cameras().size();
  if (cameras > renderer::kMostCameras) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: has {} cameras, and one view shows at most {}", path,
                                                 cameras, renderer::kMostCameras));
  }
  return FrameSources{std::vector(cameras, path), std::nullopt,
                      std::make_unique<session::Playback>(std::move(*file))};
}

}  // namespace

std::vector<stream::ListedCamera> FrameSources::listed(const scene::Scene* scene) const {
  std::vector<stream::ListedCamera> listed;
  for (std::size_t i = 0; i < names.size(); ++i) {
    listed.push_back({names[i], {}});
    if (playback) listed.back().name = playback->file().cameras()[i].name;
    if (playback || !scene) continue;
    const auto known = std::find_if(scene->cameras.begin(), scene->cameras.end(),
                                    [&](const scene::Camera& camera) { return camera.address == names[i]; });
    if (known != scene->cameras.end()) listed.back().name = known->name;
  }
  return listed;
}

stream::ReconnectingSource::Connect FrameSources::connect(std::size_t source) const {
  if (playback) {
    return [this, source](const std::stop_token& stop) { return playback->connect(source, stop); };
  }
  return [address = names[source], key = key ? &*key : nullptr](const std::stop_token& stop) {
    return stream::connect_live(address, kConnectTimeout, stop, key);
  };
}

Result<FrameSources> open_sources(const ClientSettings& settings, const scene::Scene* scene) {
  if (!settings.replay.empty()) return open_replay(settings.replay);
  auto servers = addresses(settings, scene);
  if (!servers) return fail(servers.error());
  auto key = room_key(settings, scene);
  if (!key) return fail(key.error());
  return FrameSources{std::move(*servers), std::move(*key), nullptr};
}

}  // namespace copresence::client
