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

/// Reads which cameras the room has, from the command line or the scene file.
Result<std::vector<forwarding::RoomCamera>> list_cameras(const GatewaySettings& settings) {
  std::vector<forwarding::RoomCamera> cameras;
  for (const std::string& address : settings.servers) cameras.push_back({"", address});
  if (cameras.empty()) {
    const auto scene = scene::load(settings.scene);
    if (!scene) return fail(scene.error());
    for (const scene::Camera& camera : scene->cameras) {
      if (!camera.address.empty()) cameras.push_back({camera.name, camera.address});
    }
    if (cameras.empty()) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: no camera has an \"address\" to connect to", settings.scene));
    }
  }
  if (cameras.size() > kMostCameras) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} cameras have an \"address\", and a room has at most {}", settings.scene,
                            cameras.size(), kMostCameras));
  }
  for (const forwarding::RoomCamera& camera : cameras) {
    if (const auto good = wire::parse_host_port(camera.address); !good) return fail(good.error());
  }
  return cameras;
}

/// Listens where other machines can connect only if the viewers need a token, or if everybody may watch.
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
  const auto cameras = list_cameras(settings);
  if (!cameras) return fail(cameras.error());
  auto access = open_access(settings);
  if (!access) return fail(access.error());
  const auto socket = listen(settings);
  if (!socket) return fail(socket.error());

  std::vector<std::unique_ptr<CameraFeed>> feeds;
  forwarding::Room room(*cameras, [&feeds](std::size_t camera) { feeds[camera]->request_keyframe(); });
  const web::ServerOptions options{
      std::move(*access), settings.max_viewers, {settings.certificate, settings.private_key}};
  const auto server =
      web::WebServer::open(*socket, options, room, [](const std::string& line, bool is_warning) {
        spdlog::log(is_warning ? spdlog::level::warn : spdlog::level::info, "{}", line);
      });
  if (!server) return fail(server.error());
  log_start(settings, *socket, cameras->size());

  Refusals refusals(cameras->size());
  for (std::size_t i = 0; i < cameras->size(); ++i) {
    const auto pass_on = [&, i](forwarding::CameraEvent event) {
      (*server)->post([&, i, event = std::move(event)] {
        room.take(i, event, steady_clock::now());
        if (std::holds_alternative<forwarding::FrameCame>(event)) feeds[i]->frame_taken();
      });
    };
    feeds.push_back(
        std::make_unique<CameraFeed>(static_cast<std::uint8_t>(i), (*cameras)[i].address, pass_on));
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
