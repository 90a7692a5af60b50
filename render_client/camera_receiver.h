#pragma once

// Receives, decodes, filters and clips the frames of one camera, and puts them into a mailbox. Also
// remembers surfaces that the camera saw earlier and that something hides now.
// Thread: call run() on a thread of its own. Mailboxes, states and statistics may be shared.

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/flow/mailboxes.h"
#include "common/frame/stream_description.h"
#include "common/result.h"
#include "common/scene/scene.h"
#include "common/tls/room_key.h"
#include "render_client/background_memory/background_memory.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/decoding/frame_conditioning.h"
#include "render_client/decoding/frame_decoding.h"
#include "render_client/statistics/statistics.h"
#include "render_client/stream/camera_states.h"
#include "common/wire/limited_log.h"
#include "render_client/stream/reconnecting_source.h"

namespace copresence::client {

class CameraReceiver {
 public:
  /// `address` is HOST:PORT. `key` is the room's key, or null for a server without one. `slot` is
  /// the camera's number in `mailboxes` and `states`. `scene` may be null. `remembers` tells whether
  /// the views show remembered backgrounds. All referenced objects must outlive the receiver.
  CameraReceiver(const std::string& address, const tls::RoomKey* key, std::size_t slot,
                 const scene::Scene* scene, bool remembers, flow::Mailboxes<CameraFrame>& mailboxes,
                 statistics::CameraStatistics& statistics, stream::CameraStates& states);

  /// Runs until a stop is requested or the server refuses this program's protocol version.
  void run(const std::stop_token& stop);

 private:
  Result<std::string> begin(const StreamDescription& description);
  void take(const wire::ReceivedFrame& received);

  std::string address_;
  std::size_t slot_;
  const scene::Scene* scene_;
  flow::Mailboxes<CameraFrame>& mailboxes_;
  statistics::CameraStatistics& statistics_;
  wire::LimitedLog log_;
  stream::ReconnectingSource source_;

  // Description and setup of the current connection.
  std::shared_ptr<const StreamDescription> description_;
  std::shared_ptr<const CameraSetup> setup_;
  std::optional<decoding::FrameDecoding> decoding_;
  decoding::FrameConditioner conditioner_;
  std::optional<background_memory::BackgroundMemory> background_;  // Empty if no view shows it.
};

}  // namespace copresence::client
