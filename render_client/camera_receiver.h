#pragma once

// Receives, decodes, filters and clips the frames of one camera, and puts them into a mailbox. Also
// remembers surfaces that the camera saw earlier and that something hides now, and hands the frames
// to the recorder.
// Thread: call run() on a thread of its own. Mailboxes, states and statistics may be shared.

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/flow/mailboxes.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/scene/scene.h"
#include "common/wire/limited_log.h"
#include "render_client/background_memory/background_memory.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/decoding/frame_conditioning.h"
#include "render_client/decoding/frame_decoding.h"
#include "render_client/moving_surfaces/motion_detector.h"
#include "render_client/session_recorder.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_states.h"
#include "render_client/stream/reconnecting_source.h"

namespace copresence::client {

class CameraReceiver {
 public:
  /// The receiver's camera.
  struct Camera {
    std::string address;  ///< HOST:PORT or the path of a recording, for the log.
    std::size_t slot;     ///< The camera's number in mailboxes, states and the recorder.
    stream::ReconnectingSource::Connect connect;
    /// The clock of the frames' arrival: this process's clock, or the position of a replay.
    std::function<Instant()> now;
  };
  /// `scene` and `recorder` may be null. `remembers` tells whether the views show remembered
  /// backgrounds. All referenced objects must outlive the receiver.
  CameraReceiver(Camera camera, const scene::Scene* scene, bool remembers,
                 flow::Mailboxes<CameraFrame>& mailboxes, statistics::CameraStatistics& statistics,
                 stream::CameraStates& states, SessionRecorder* recorder);

  /// Runs until a stop is requested or the server refuses this program's protocol version.
  void run(const std::stop_token& stop);

 private:
  Result<std::string> begin(const StreamDescription& description);
  void take(wire::ReceivedFrame received);

  Camera camera_;
  const scene::Scene* scene_;
  flow::Mailboxes<CameraFrame>& mailboxes_;
  statistics::CameraStatistics& statistics_;
  SessionRecorder* recorder_;
  wire::LimitedLog log_;
  stream::ReconnectingSource source_;

  // Description and setup of the current connection.
  std::shared_ptr<const StreamDescription> description_;
  std::shared_ptr<const CameraSetup> setup_;
  std::optional<decoding::FrameDecoding> decoding_;
  decoding::FrameConditioner conditioner_;
  std::optional<background_memory::BackgroundMemory> background_;  // Empty if no view shows it.
  Instant newest_at_{};                                            // Capture time of the last frame.
  moving_surfaces::MotionDetector motion_;
};

}  // namespace copresence::client
