#include "render_client/session_recorder.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <utility>

namespace copresence::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kDrainFor{700};
constexpr milliseconds kSayEvery{5000};
/// Servers make at most one keyframe a second on request.
constexpr milliseconds kRequestEvery{1000};

}  // namespace

SessionRecorder::SessionRecorder(session::SessionWriter writer, std::size_t cameras)
    : writer_(std::move(writer)), cameras_(cameras) {
  spdlog::info("recording to {}", writer_.path());
  thread_ = std::jthread([this] { run(); });
}

SessionRecorder::~SessionRecorder() {
  give_up_at_ = steady_clock::now() + kDrainFor;
  waiting_.close();
}

bool SessionRecorder::offer(std::size_t camera, std::shared_ptr<const StreamDescription> description,
                            EncodedFrame frame, Instant captured_at) {
  if (is_over_) return false;
  Camera& of = cameras_[camera];
  const Instant now = steady_clock::now();
  if (frame.keyframe) {
    of.keyframe_at = now;
    of.has_gap = false;
  }
  // Frames after a gap could not be decoded.
  if (of.has_gap || !waiting_.put({camera, std::move(description), std::move(frame), captured_at})) {
    of.has_gap = true;
    leave_out(now);
  }
  const bool needs_keyframe = of.has_gap || now >= of.keyframe_at + kKeyframeEvery;
  if (!needs_keyframe || now < of.requested_at + kRequestEvery) return false;
  of.requested_at = now;
  return true;
}

void SessionRecorder::leave_out(Instant now) {
  const std::uint64_t left_out = ++left_out_;
  Instant due = say_again_at_;
  if (now < due || !say_again_at_.compare_exchange_strong(due, now + kSayEvery)) return;
  spdlog::warn("{}: {} frames left out so far: the disk is too slow to record", writer_.path(), left_out);
}

void SessionRecorder::run() {
  pthread_setname_np(pthread_self(), "record");
  while (const auto waiting = waiting_.take()) {
    if (is_over_ || steady_clock::now() > give_up_at_.load()) {
      ++left_out_;
    } else {
      write(*waiting);
    }
  }
  if (!is_over_) finish();
}

void SessionRecorder::write(const Waiting& waiting) {
  const auto written = writer_.write(waiting.camera, waiting.description, waiting.frame, waiting.captured_at);
  if (written) return;
  ++left_out_;
  if (written.error().code == ErrorCode::kCorrupt) {
    spdlog::debug("a frame is left out of the recording: {}", written.error().what);
    return;
  }
  is_over_ = true;
  spdlog::error("{}; the recording ends here, the view goes on", written.error().what);
  finish();
}

void SessionRecorder::finish() {
  if (auto finished = writer_.finish(); !finished) spdlog::error("{}", finished.error().what);
  spdlog::info("{}: {} frames, {:.1f} s, {:.1f} MB, {} frames left out", writer_.path(), writer_.frames(),
               std::chrono::duration<double>(writer_.duration()).count(),
               static_cast<double>(writer_.bytes()) * 1e-6, left_out_.load());
}

}  // namespace copresence::client
