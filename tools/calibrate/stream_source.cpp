#include "tools/calibrate/stream_source.h"

#include <fmt/format.h>

#include <chrono>

#include "common/wire/frame_client.h"
#include "render_client/decoding/frame_decoding.h"
#include "render_client/stream/limited_log.h"

namespace copresence::calibrate {
namespace {

constexpr std::chrono::milliseconds kConnectTimeout{2000};
constexpr int kMostLost = 90;                  // frames in a row that do not decode
constexpr std::chrono::seconds kPatience{10};  // a camera that is plugged in again is back by then

class StreamSource : public sensor::FrameSource {
 public:
  StreamSource(const std::string& address, wire::FrameClient client, decoding::FrameDecoding decoding)
      : client_(std::move(client)), decoding_(std::move(decoding)) {
    client_.on_camera_status([this, address](const std::string& notice) {
      notice_ = notice;
      if (notice.empty()) return;
      log_.say(stream::LimitedLog::Topic::kNotice, stream::LimitedLog::Severity::kWarning,
               fmt::format("{}: {}", address, notice), std::chrono::steady_clock::now());
    });
    const StreamDescription& stream = client_.description();
    description_.name = stream.camera;
    description_.depth = description_.color = stream.model;
    description_.unit = stream.unit;
    description_.noise = stream.noise;
    description_.has_color = stream.has_color;
    description_.registered = true;
    description_.frames_per_second = stream.frames_per_second;
    if (stream.has_pose) description_.world_from_camera = stream.world_from_camera;
  }

  const sensor::SensorDescription& description() const override { return description_; }
  sensor::SourceCounters counters() const override { return counters_; }

  Result<RgbdFrame> next(std::stop_token stop) override {
    for (int lost = 0; lost < kMostLost; ++lost) {
      const auto received = client_.receive(stop, std::chrono::steady_clock::now() + kPatience);
      if (!received && received.error().code == ErrorCode::kTimeout) {
        return fail(ErrorCode::kTimeout,
                    notice_.empty() ? received.error().what : received.error().what + ": " + notice_);
      }
      if (!received) return fail(received.error());
      decoding::FrameDecoding::Durations durations;
      auto frame = decoding_.decode(received->frame, durations);
      if (!frame) {
        ++counters_.damaged;
        client_.request_keyframe();
        continue;
      }
      for (std::size_t i = 0; i < frame->depth.pixels().size(); ++i) {
        if (frame->state.data()[i] != DepthState::kMeasured) frame->depth.data()[i] = 0;
      }
      ++counters_.frames;
      return frame;
    }
    return fail(ErrorCode::kCorrupt,
                fmt::format("camera \"{}\" sends frames that do not decode", description_.name));
  }

 private:
  StreamSource(const StreamSource&) = delete;  // the client calls back
  StreamSource& operator=(const StreamSource&) = delete;

  wire::FrameClient client_;
  stream::LimitedLog log_{
      [](stream::LimitedLog::Severity, const std::string& line) { fmt::print(stderr, "{}\n", line); }};
  std::string notice_;  // what keeps the camera from sending, in the server's words; empty where nothing does
  decoding::FrameDecoding decoding_;
  sensor::SensorDescription description_;
  sensor::SourceCounters counters_;
};

}  // namespace

Result<std::unique_ptr<sensor::FrameSource>> open_stream(const std::string& address) {
  auto client = wire::FrameClient::connect(address, kConnectTimeout, {});
  if (!client) return fail(client.error());
  auto decoding = decoding::FrameDecoding::open(client->description());
  if (!decoding) return fail(decoding.error());
  return std::make_unique<StreamSource>(address, std::move(*client), std::move(*decoding));
}

}  // namespace copresence::calibrate
