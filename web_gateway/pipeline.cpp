#include "web_gateway/pipeline.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "common/scene/scene.h"
#include "common/tls/room_key.h"
#include "common/wire/host_port.h"
#include "common/wire/listening_socket.h"
#include "web_gateway/camera_feed.h"
#include "web_gateway/forwarding/room.h"
#include "web_gateway/page/page_files.h"
#include "web_gateway/token.h"
#include "web_gateway/web/web_server.h"

namespace copresence::gateway {
namespace {

using std::chrono::steady_clock;

/// The cameras of a room, and the key of their servers.
struct RoomSettings {
  scene::Scene scene;  // Empty without a scene file.
  std::vector<forwarding::RoomCamera> cameras;
  std::optional<tls::RoomKey> key;  // Empty if the servers have none.
};

/// Takes the cameras and the key from the command line, and what is missing there from the scene
/// file.
Result<RoomSettings> read_room(const GatewaySettings& settings) {
  RoomSettings room;
  if (!settings.scene.empty()) {
    auto scene = scene::load(settings.scene);
    if (!scene) return fail(scene.error());
    room.scene = std::move(*scene);
  }
  for (const std::string& address : settings.servers) room.cameras.push_back({"", address});
  if (settings.servers.empty()) {
    for (const scene::Camera& camera : room.scene.cameras) {
      if (!camera.address.empty()) room.cameras.push_back({camera.name, camera.address});
    }
  }
  if (room.cameras.empty() || room.cameras.size() > kMostCameras) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} cameras have an \"address\" to connect to, and a room has 1 to {}",
                            settings.scene, room.cameras.size(), kMostCameras));
  }
  for (const forwarding::RoomCamera& camera : room.cameras) {
    if (const auto good = wire::parse_host_port(camera.address); !good) return fail(good.error());
  }
  const std::string& key_file = settings.key.empty() ? room.scene.key : settings.key;
  if (key_file.empty()) return room;
  const auto key = tls::read_key(key_file);
  if (!key) return fail(key.error());
  room.key = *key;
  return room;
}

/// Adds what the scene file knows of a camera: its intrinsics, and its pose if the server has none.
void complete(StreamDescription& stream, const scene::Scene& scene) {
  const scene::Camera* const known = scene.find(stream.camera);
  if (!known) return;
  if (known->model.width == stream.model.width && known->model.height == stream.model.height)
    stream.model = known->model;
  if (!stream.has_pose && known->world_from_camera) {
    stream.has_pose = true;
    stream.world_from_camera = *known->world_from_camera;
  }
}

/// Listens where other machines can connect only if the viewers need a token, or if everybody may
/// watch.
Result<wire::ListeningSocket> listen(const GatewaySettings& settings) {
  auto socket = wire::listen(settings.listen, wire::Reach::kOtherMachines);
  if (socket && !socket->is_loopback() && settings.token.empty() && !settings.open) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{} can be reached from other machines: give --token FILE (web_gateway "
                            "--make-token FILE makes one), or --open if everybody may watch",
                            settings.listen));
  }
  return socket;
}

Result<web::Access> open_access(const GatewaySettings& settings) {
  web::Access access;
  access.is_open = settings.open;
  if (settings.token.empty()) return access;
  auto token = read_token(settings.token);
  if (!token) return fail(token.error());
  access.token = std::move(*token);
  return access;
}

void log_start(const GatewaySettings& settings, const wire::ListeningSocket& socket, std::size_t cameras) {
  const bool https = !settings.certificate.empty();
  const std::string address = fmt::format("{}://{}/", https ? "https" : "http", socket.address());
  spdlog::info("serves {} camera{} to browsers on {}", cameras, cameras == 1 ? "" : "s", address);
  if (!settings.token.empty()) {
    spdlog::info("the link for viewers ends with the token: {}#token=$(cat {})", address, settings.token);
  }
  if (!page::is_built()) {
    spdlog::warn(
        "this program was built without the page, so browsers show no room: ./run web builds the "
        "page, ./run build puts it in");
  }
  if (!https && !socket.is_loopback()) {
    spdlog::warn(
        "browsers on other machines show the room over HTTPS only: give --certificate and "
        "--private-key, or put a web server with a certificate before this gateway");
  }
}

/// The cameras that refuse this program for good.
class Refusals {
 public:
  explicit Refusals(std::size_t cameras) : cameras_(cameras) {}

  /// Returns true if now every camera has refused.
  bool add(const Error& why) {
    const std::lock_guard lock(mutex_);
    if (!what_.empty()) what_ += "; ";
    what_ += why.what;
    return ++refused_ == cameras_;
  }
  std::optional<Error> of_all() const {
    const std::lock_guard lock(mutex_);
    if (refused_ < cameras_) return std::nullopt;
    return Error{ErrorCode::kRefused, what_};
  }

 private:
  mutable std::mutex mutex_;
  std::size_t cameras_, refused_ = 0;
  std::string what_;
};

}  // namespace

Result<void> run_gateway(const GatewaySettings& settings, std::stop_source stop) {
  const auto settings_of_room = read_room(settings);
  if (!settings_of_room) return fail(settings_of_room.error());
  const auto& cameras = settings_of_room->cameras;
  const tls::RoomKey* const key = settings_of_room->key ? &*settings_of_room->key : nullptr;
  auto access = open_access(settings);
  if (!access) return fail(access.error());
  const auto socket = listen(settings);
  if (!socket) return fail(socket.error());

  std::vector<std::unique_ptr<CameraFeed>> feeds;
  forwarding::Room room(cameras, [&feeds](std::size_t camera) { feeds[camera]->request_keyframe(); });
  const web::ServerOptions options{
      std::move(*access), settings.max_viewers, {settings.certificate, settings.private_key}};
  const auto server =
      web::WebServer::open(*socket, options, room, [](const std::string& line, bool is_warning) {
        spdlog::log(is_warning ? spdlog::level::warn : spdlog::level::info, "{}", line);
      });
  if (!server) return fail(server.error());
  log_start(settings, *socket, cameras.size());

  Refusals refusals(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto pass_on = [&, i](forwarding::CameraEvent event) {
      if (auto* const connected = std::get_if<forwarding::Connected>(&event))
        complete(connected->description, settings_of_room->scene);
      (*server)->post([&, i, event = std::move(event)] {
        room.take(i, event, steady_clock::now());
        if (std::holds_alternative<forwarding::FrameCame>(event)) feeds[i]->frame_taken();
      });
    };
    feeds.push_back(
        std::make_unique<CameraFeed>(static_cast<std::uint8_t>(i), cameras[i].address, key, pass_on));
  }
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    threads.emplace_back([&, i] {
      pthread_setname_np(pthread_self(), fmt::format("camera {}", i).c_str());
      const auto ran = feeds[i]->run(stop.get_token());
      if (!ran && refusals.add(ran.error())) stop.request_stop();
    });
  }
  (*server)->run(stop.get_token());
  stop.request_stop();
  threads.clear();
  if (auto refused = refusals.of_all()) return fail(std::move(*refused));
  return {};
}

}  // namespace copresence::gateway
