#include "capture_server/encode_stage.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <thread>
#include <utility>

#include "common/flow/drop_stale.h"
#include "common/flow/thread_priority.h"
#include "common/flow/worker_pool.h"

namespace copresence::server {

std::string depth_quality(const EncoderSettings& settings) {
  return settings.depth_kbps ? fmt::format("{} kbit/s", *settings.depth_kbps)
                             : fmt::format("qp {}", settings.depth_qp);
}

Result<void> EncodeStage::run(flow::Mailbox<CapturedFrame>& captured, Pulse pulse) {
  using std::chrono::steady_clock;
  flow::lower_priority(kStepsBelowRendering);
  flow::WorkerPool workers(std::thread::hardware_concurrency() > 1 ? 2 : 1, "encode");
  const Duration period = std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(1 / encoding_.description().frames_per_second));
  std::uint64_t last = 0;  // Sequence number of the last frame.
  for (Instant free = steady_clock::now(); auto next = captured.take({});
       free = steady_clock::now(), pulse.rest()) {
    pulse.beat();
    if (const auto settings = changes_.try_take()) change(*settings);
    const FrameMetadata& metadata = next->frame.metadata;
    if (metadata.sequence > last) encoder_busy_ += metadata.sequence - last - 1;
    last = metadata.sequence;
    if (!server_.wants_frames()) {
      ++without_room_;
    } else if (!settings_.keeps_every_frame() &&
               flow::should_drop_stale(metadata.captured_at, free, period)) {
      ++encoder_busy_;
    } else if (auto encoded = encode(std::move(*next), workers); !encoded) {
      return encoded;
    }
  }
  return {};
}

Result<void> EncodeStage::encode(CapturedFrame captured, Executor& workers) {
  const std::uint64_t sequence = captured.frame.metadata.sequence;
  const bool keyframe = server_.take_keyframe_request() || keyframe_owed_;
  auto encoded = encoding_.encode(std::move(captured.frame), keyframe, &workers);
  keyframe_owed_ = !encoded;
  if (encoded) {
    const sensor::SourceCounters& pictures = captured.pictures;
    server_.send(std::make_shared<const EncodedFrame>(std::move(*encoded)),
                 {sequence, encoder_busy_, without_room_, pictures.depth_without_color,
                  pictures.color_without_depth, pictures.damaged, pictures.late, pictures.projector_off});
    return {};
  }
  ++encoder_busy_;
  if (encoded.error().code != ErrorCode::kUnsupported) {
    spdlog::warn("{}: frame {} is left out: {}", settings_.name, sequence, encoded.error().what);
    return {};
  }
  if (!previous_) return fail(encoded.error());
  spdlog::warn("{}: {}; depth goes on at {}", settings_.name, encoded.error().what,
               depth_quality(*previous_));
  change(EncoderSettings(*previous_));
  previous_.reset();
  return {};
}

void EncodeStage::change(const EncoderSettings& settings) {
  if (const auto changed = encoding_.change_settings(settings); !changed) {
    spdlog::warn("{}: {}; the encoder settings stay as they are", settings_.name, changed.error().what);
    return;
  }
  previous_ = std::exchange(current_, settings);
}

}  // namespace copresence::server
