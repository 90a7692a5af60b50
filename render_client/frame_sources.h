#pragma once

// Where the frames of a view come from: servers, or the cameras of a session recording.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/scene/scene.h"
#include "common/tls/room_key.h"
#include "render_client/session/playback.h"
#include "render_client/settings.h"
#include "render_client/stream/camera_states.h"
#include "render_client/stream/reconnecting_source.h"

namespace copresence::client {

struct FrameSources {
  /// The names of the sources for the log: addresses of servers, or the path of a recording.
  std::vector<std::string> names;
  std::optional<tls::RoomKey> key;              ///< Empty if the servers have none.
  std::unique_ptr<session::Playback> playback;  ///< Null for servers.

  /// Returns the cameras with their names, as far as the scene file or the recording has them.
  std::vector<stream::ListedCamera> listed(const scene::Scene* scene) const;

  /// Returns the function that connects to a source. It uses this object, which must outlive it.
  stream::ReconnectingSource::Connect connect(std::size_t source) const;
};

/// Opens the recording of --replay, or lists the servers of --connect or the scene file. Servers
/// are not connected to yet. `scene` may be null. Fails with a sentence for the user.
Result<FrameSources> open_sources(const ClientSettings& settings, const scene::Scene* scene);

}  // namespace copresence::client
