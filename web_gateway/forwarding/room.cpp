#include "web_gateway/forwarding/room.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <utility>

namespace copresence::forwarding {
namespace {

constexpr std::chrono::seconds kBetweenKeyframeRequests{1};
// A smaller change of a clock's offset is not announced to viewers.
constexpr std::chrono::microseconds kClockChange{500};
// Of a camera that has not been connected yet. Its frames come only after its description.
constexpr std::chrono::milliseconds kUnknownPeriod{33};

Duration frame_period(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / stream.frames_per_second));
}

wire::Bytes of_camera(std::size_t camera, const wire::Bytes& message) {
  wire::Bytes bytes;
  bytes.reserve(1 + message.size());
  bytes.push_back(static_cast<std::uint8_t>(camera));
  bytes.insert(bytes.end(), message.begin(), message.end());
  return bytes;
}

}  // namespace

Room::Room(std::vector<RoomCamera> cameras, RequestKeyframe request_keyframe)
    : request_keyframe_(std::move(request_keyframe)) {
  assert(cameras.size() <= 256);
  for (RoomCamera& listed : cameras) {
    Camera camera;
    camera.state_text = "connecting to " + listed.address;
    camera.listed = std::move(listed);
    cameras_.push_back(std::move(camera));
  }
}

void Room::take(std::size_t camera, const CameraEvent& event, Instant now) {
  std::visit([&](const auto& what) { on(camera, what, now); }, event);
}

void Room::on(std::size_t index, const Connected& event, Instant now) {
  Camera& camera = cameras_[index];
  camera.description = event.description;
  camera.clock = event.clock;
  camera.announced_offset = event.clock.offset;
  camera.status.clear();
  camera.group.clear();
  camera.listed.name = event.description.camera;
  enter(index, CameraState::kConnected, "");
  for (Viewer* viewer : viewers_) {
    viewer->streams_[index].restart(frame_period(event.description));
    begin_stream(index, *viewer, now);
  }
}

void Room::on(std::size_t index, const FrameCame& event, Instant now) {
  Camera& camera = cameras_[index];
  camera.clock = event.clock;
  if (std::chrono::abs(event.clock.offset - camera.announced_offset) >= kClockChange) {
    camera.announced_offset = event.clock.offset;
    send_to_all(clock_message(index, event.clock.offset));
  }
  camera.group.add(event.frame);
  bool needs_keyframe = false;
  for (Viewer* viewer : viewers_) {
    ViewerStream& stream = viewer->streams_[index];
    stream.frame_came(event.frame, camera.group, now, viewer->to_outlet());
    needs_keyframe |= stream.needs_keyframe(camera.group, now);
  }
  if (needs_keyframe) request_keyframe(index, now);
}

void Room::on(std::size_t index, const StatusChanged& event, Instant) {
  cameras_[index].status = event.text;
  send_to_all(of_camera(index, encode(wire::CameraStatus{event.text})));
  enter(index, event.text.empty() ? CameraState::kConnected : CameraState::kWaiting, event.text);
}

void Room::on(std::size_t index, const Disconnected& event, Instant) {
  if (cameras_[index].description && event.ended_the_stream) {
    send_to_all(of_camera(index, encode(wire::EndOfStream{event.why})));
  }
  cameras_[index].description.reset();
  cameras_[index].group.clear();
  enter(index, event.is_final ? CameraState::kFailed : CameraState::kWaiting, event.why);
}

std::unique_ptr<Viewer> Room::join(Outlet& outlet, Instant now) {
  std::unique_ptr<Viewer> viewer(new Viewer(*this, outlet));
  std::vector<RoomCamera> listed;
  for (const Camera& camera : cameras_) listed.push_back(camera.listed);
  outlet.send(room_message(listed));
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    outlet.send(state_message(i, cameras_[i].state, cameras_[i].state_text));
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (!cameras_[i].description) continue;
    begin_stream(i, *viewer, now);
    viewer->catch_up(i, now);
  }
  return viewer;
}

void Room::enter(std::size_t index, CameraState state, std::string text) {
  Camera& camera = cameras_[index];
  if (camera.state == state && camera.state_text == text) return;
  camera.state = state;
  camera.state_text = std::move(text);
  send_to_all(state_message(index, state, camera.state_text));
}

void Room::begin_stream(std::size_t index, Viewer& viewer, Instant now) const {
  const Camera& camera = cameras_[index];
  // The page knows its gateway's clock only, so the clock's number says nothing to it.
  const wire::Welcome welcome{0, now + camera.clock.offset, *camera.description};
  viewer.outlet_.send(of_camera(index, encode(welcome)));
  viewer.outlet_.send(clock_message(index, camera.announced_offset));
  if (!camera.status.empty()) {
    viewer.outlet_.send(of_camera(index, encode(wire::CameraStatus{camera.status})));
  }
}

void Room::send_to_all(const ViewerMessage& message) const {
  for (const Viewer* viewer : viewers_) viewer->outlet_.send(message);
}

void Room::request_keyframe(std::size_t index, Instant now) {
  Camera& camera = cameras_[index];
  if (!camera.description) return;
  if (camera.keyframe_requested_at && now - *camera.keyframe_requested_at < kBetweenKeyframeRequests) return;
  camera.keyframe_requested_at = now;
  request_keyframe_(index);
}

Viewer::Viewer(Room& room, Outlet& outlet) : room_(room), outlet_(outlet) {
  for (const Room::Camera& camera : room.cameras_) {
    streams_.emplace_back(camera.description ? frame_period(*camera.description) : kUnknownPeriod);
  }
  room_.viewers_.push_back(this);
}

Viewer::~Viewer() {
  std::erase(room_.viewers_, this);
}

bool Viewer::take(std::span<const std::uint8_t> message, Instant now) {
  if (message.size() < 1 + wire::kHeaderBytes || message[0] >= streams_.size()) return false;
  const std::size_t camera = message[0];
  const auto header = wire::decode_header(message.subspan<1, wire::kHeaderBytes>());
  const auto body = message.subspan(1 + wire::kHeaderBytes);
  if (!header || header->body_bytes != body.size()) return false;
  switch (header->type) {
    case wire::MessageType::kFrameAck: {
      const auto ack = wire::decode_frame_ack(body);
      const FrameGroup& group = room_.cameras_[camera].group;
      if (!ack || !streams_[camera].acknowledge(ack->sequence, group, now, to_outlet())) return false;
      if (streams_[camera].needs_keyframe(group, now)) room_.request_keyframe(camera, now);
      return true;
    }
    case wire::MessageType::kKeyframeRequest:
      room_.request_keyframe(camera, now);
      return true;
    case wire::MessageType::kPing: {
      const auto ping = wire::decode_ping(body);
      if (!ping) return false;
      outlet_.send(of_camera(camera, encode(wire::Pong{ping->client_time, now})));
      return true;
    }
    default:
      return false;
  }
}

std::optional<Instant> Viewer::waits_since() const {
  std::optional<Instant> first;
  for (const ViewerStream& stream : streams_) {
    const auto since = stream.waits_since();
    if (since && (!first || *since < *first)) first = since;
  }
  return first;
}

ViewerStream::Send Viewer::to_outlet() {
  return [this](const SharedFrame& frame) { outlet_.send(frame); };
}

void Viewer::catch_up(std::size_t camera, Instant now) {
  const FrameGroup& group = room_.cameras_[camera].group;
  streams_[camera].catch_up(group, now, to_outlet());
  if (streams_[camera].needs_keyframe(group, now)) room_.request_keyframe(camera, now);
}

}  // namespace copresence::forwarding
