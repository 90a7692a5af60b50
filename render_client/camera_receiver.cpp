#include "render_client/camera_receiver.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>

#include "common/frame/waiting.h"
#include "common/wire/end_of_stream.h"

namespace copresence::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kFirstBackoff{50}, kLongestBackoff{500}, kConnectTimeout{2000};

bool is_final(const Error& error) {
  return error.code == ErrorCode::kRefused || error.code == ErrorCode::kUnsupported ||
         error.code == ErrorCode::kInvalid;
}

}  // namespace

CameraReceiver::CameraReceiver(std::string address, std::size_t slot, const scene::Scene* scene,
                               flow::LatestOfEach<Received>& board, CameraStatistics& statistics,
                               CameraStates& states)
    : address_(std::move(address)),
      slot_(slot),
      scene_(scene),
      board_(board),
      statistics_(statistics),
      states_(states) {}

Result<void> CameraReceiver::run(std::stop_token stop) {
  Duration backoff = kFirstBackoff;
  while (!stop.stop_requested()) {
    auto client = wire::FrameClient::connect(address_, kConnectTimeout, stop);
    if (client) {
      spdlog::info("{}: connected to camera \"{}\"", address_, client->description().camera);
      states_.connected(slot_, client->description().camera);
      backoff = kFirstBackoff;
      client->on_notice([&, camera = client->description().camera](const std::string& notice) {
        states_.notice(slot_, notice);
        if (notice.empty()) {
          spdlog::info("{}: camera \"{}\" is back", address_, camera);
        } else {
          spdlog::warn("{}: {}", address_, notice);
        }
      });
      const auto ended = receive_from(*client, stop);
      if (!ended && is_final(ended.error())) return ended;
      if (!ended && !stop.stop_requested()) spdlog::warn("{}", ended.error().what);
    } else if (is_final(client.error())) {
      return fail(client.error());
    } else if (!stop.stop_requested()) {
      const auto line = states_.not_connected(slot_, client.error().what, steady_clock::now());
      if (line) spdlog::info("{}", *line);
    }
    wait_for(backoff, stop);
    backoff = std::min<Duration>(backoff * 2, kLongestBackoff);
  }
  return {};
}

Error CameraReceiver::named(const Error& error) const {
  return {error.code, fmt::format("{}: {}", address_, error.what)};
}

Result<void> CameraReceiver::receive_from(wire::FrameClient& client, std::stop_token stop) {
  Stream stream;
  stream.description = std::make_shared<const StreamDescription>(client.description());
  auto decoding = FrameDecoding::open(*stream.description);
  if (!decoding) return fail(named(decoding.error()));
  stream.setup = std::make_shared<const CameraSetup>(resolve_setup(*stream.description, scene_));
  if (!stream.setup->remark.empty()) spdlog::warn("{}: {}", address_, stream.setup->remark);
  if (scene_ && scene_->clip) stream.clipper.emplace(*stream.setup, *scene_->clip);
  while (!stop.stop_requested()) {
    auto received = client.receive(stop);
    if (!received) {
      const bool server_says_so = received.error().code == ErrorCode::kEndOfStream;
      if (server_says_so && wire::ends_for_good(received.error().what))
        states_.over(slot_, received.error().what);
      return fail(server_says_so ? named(received.error()) : received.error());
    }
    const EncodedFrame& encoded = received->frame;
    statistics_.received(received->counters.captured, received->counters.encoder_busy,
                         received->counters.window_full, encoded.depth.size() + encoded.color.size(),
                         received->received_at);
    statistics_.sensor({received->counters.depth_without_color, received->counters.color_without_depth,
                        received->counters.damaged, received->counters.dark});
    statistics_.stage(Stage::kWire, received->received_at - client.clock().to_local(received->sent_at));

    FrameDecoding::Durations durations;
    auto frame = decoding->decode(encoded, durations);
    if (!frame) {
      statistics_.not_decoded();
      client.request_keyframe();
      spdlog::debug("{}: {}", address_, frame.error().what);
      continue;
    }
    statistics_.decoded();
    if (decoding->repeat_color(*frame)) statistics_.color_repeated();
    statistics_.stage(Stage::kCapture, encoded.durations.capture);
    statistics_.stage(Stage::kFill, encoded.durations.fill);
    statistics_.stage(Stage::kDepthEncode, encoded.durations.depth_encode);
    statistics_.stage(Stage::kVideoEncode, encoded.durations.video_encode);
    statistics_.stage(Stage::kVideoDecode, durations.video_decode);
    statistics_.stage(Stage::kDepthDecode, durations.depth_decode);
    hand_over(client, std::move(*frame), stream);
  }
  return {};
}

void CameraReceiver::hand_over(const wire::FrameClient& client, RgbdFrame frame, const Stream& stream) {
  temporal_filter_.apply(frame, stream.description->unit);
  if (stream.clipper) stream.clipper->apply(frame);
  smoothing_.smooth(frame.depth, stream.description->unit);
  const wire::ClockOffset clock = client.clock();
  statistics_.clock(clock.offset, clock.uncertainty);
  const Instant captured_at = clock.to_local(frame.stamp.captured_at);
  if (board_.put(slot_,
                 {std::move(frame), captured_at, steady_clock::now(), stream.description, stream.setup}))
    statistics_.unshown();
}

}  // namespace copresence::client
