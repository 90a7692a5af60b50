#pragma once

// The room that a gateway serves: its cameras and its viewers. A Room passes every camera's
// messages to all viewers, each at the viewer's own pace (viewer_stream.h). It has no sockets: a
// viewer's messages go to its Outlet. Thread: one thread.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/wire/message_codec.h"
#include "web_gateway/forwarding/camera_event.h"
#include "web_gateway/forwarding/frame_group.h"
#include "web_gateway/forwarding/page_messages.h"
#include "web_gateway/forwarding/viewer_stream.h"

namespace copresence::forwarding {

/// A message to a viewer: JSON, or bytes that begin with the camera's index, or a frame.
using ViewerMessage = std::variant<std::string, wire::Bytes, SharedFrame>;

/// Sends messages to one viewer, in order.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// Queues a message and returns at once. Must not destroy a Viewer.
  virtual void send(ViewerMessage message) = 0;
};

class Viewer;

class Room {
 public:
  /// Asks a camera's server for a keyframe.
  using RequestKeyframe = std::function<void(std::size_t camera)>;

  /// Requires at most 256 cameras, since messages have one byte for the index.
  Room(std::vector<RoomCamera> cameras, RequestKeyframe request_keyframe);

  void take(std::size_t camera, const CameraEvent& event, Instant now);

  /// Admits a viewer. The viewer gets the list of cameras, their states and their pictures at once.
  /// Room and outlet must outlive the viewer.
  std::unique_ptr<Viewer> join(Outlet& outlet, Instant now);

 private:
  friend class Viewer;
  struct Camera {
    RoomCamera listed;
    CameraState state = CameraState::kConnecting;
    std::string state_text;
    std::optional<StreamDescription> description;  // Empty without a connection.
    wire::ClockOffset clock;
    Duration announced_offset{};  // In the last clock message.
    std::string status;           // The reason why the camera sends no frames, or empty.
    FrameGroup group;
    std::optional<Instant> keyframe_requested_at;
  };

  void on(std::size_t camera, const Connected& event, Instant now);
  void on(std::size_t camera, const FrameCame& event, Instant now);
  void on(std::size_t camera, const StatusChanged& event, Instant now);
  void on(std::size_t camera, const Disconnected& event, Instant now);
  void enter(std::size_t camera, CameraState state, std::string text);
  void begin_stream(std::size_t camera, Viewer& viewer, Instant now) const;
  void send_to_all(const ViewerMessage& message) const;
  void request_keyframe(std::size_t camera, Instant now);

  std::vector<Camera> cameras_;
  std::vector<Viewer*> viewers_;
  RequestKeyframe request_keyframe_;
};

/// One viewer of a room. The destructor leaves the room.
class Viewer {
 public:
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Takes a binary message: a camera's index and one message of the wire. Returns false if the
  /// message violates the protocol.
  bool take(std::span<const std::uint8_t> message, Instant now);

  /// When the oldest frame was sent that the viewer has not acknowledged. Empty without such a
  /// frame.
  std::optional<Instant> waits_since() const;

 private:
  friend class Room;
  Viewer(Room& room, Outlet& outlet);
  ViewerStream::Send to_outlet();
  void catch_up(std::size_t camera, Instant now);

  Room& room_;
  Outlet& outlet_;
  std::vector<ViewerStream> streams_;  // One for each camera.
};

}  // namespace copresence::forwarding
