#include <utility>

#include "render_client/stream/frame_source.h"

namespace copresence::stream {
namespace {

class LiveSource final : public FrameSource {
 public:
  explicit LiveSource(wire::FrameClient client) : client_(std::move(client)) {}

  const StreamDescription& description() const override { return client_.description(); }
  Result<wire::ReceivedFrame> next(std::stop_token stop, std::optional<Instant> latest) override {
    return client_.receive(std::move(stop), latest);
  }
  void request_keyframe() override { client_.request_keyframe(); }
  wire::ClockOffset clock() const override { return client_.clock(); }
  void on_status(std::function<void(const std::string&)> changed) override {
    client_.on_camera_status(std::move(changed));
  }

 private:
  wire::FrameClient client_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> connect_live(const std::string& host_port,
                                                  std::chrono::milliseconds timeout,
                                                  const std::stop_token& stop, const tls::RoomKey* key) {
  auto client = wire::FrameClient::connect(host_port, timeout, stop, key);
  if (!client) return fail(client.error());
  return std::make_unique<LiveSource>(std::move(*client));
}

}  // namespace copresence::stream
