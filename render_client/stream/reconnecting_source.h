#pragma once

// Receives a camera's frames over any number of connections. It connects again when the server is
// gone, logs this, and updates the camera's state. Thread: one thread, also for request_keyframe().

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/wire/limited_log.h"
#include "render_client/stream/availability.h"
#include "render_client/stream/camera_states.h"
#include "render_client/stream/frame_source.h"

namespace copresence::stream {

class ReconnectingSource final : public FrameSource {
 public:
  using Connect = std::function<Result<std::unique_ptr<FrameSource>>(const std::stop_token&)>;
  /// A function that prepares for the frames of a new connection. It returns a remark for the log,
  /// or an empty text. If it fails, the connection is closed.
  using Begin = std::function<Result<std::string>(const StreamDescription&)>;

  /// `address` names the camera in the log. `slot` is its number in `states`. The referenced
  /// objects must outlive this object.
  ReconnectingSource(std::string address, std::size_t slot, CameraStates& states, wire::LimitedLog& log,
                     Connect connect, Begin begin);

  /// Waits for the next frame of any connection. Connects again after a pause of at most half a
  /// second. Fails as FrameSource::next() does, and with kRefused if no further try can succeed.
  Result<wire::ReceivedFrame> next(std::stop_token stop, std::optional<Instant> latest = {}) override;

  /// Call one of these after each frame. undecodable() also requests a keyframe. A camera whose
  /// frames cannot be decoded for a while is left out of the view.
  void decoded();
  void undecodable(const std::string& why);

  // The following functions require a connection: next() has returned a frame, or Begin is running.
  const StreamDescription& description() const override { return source_->description(); }
  wire::ClockOffset clock() const override { return source_->clock(); }
  void request_keyframe() override { source_->request_keyframe(); }

  void on_status(std::function<void(const std::string&)> changed) override {
    on_status_ = std::move(changed);
  }

 private:
  Result<void> connect(const std::stop_token& stop);
  /// Ends the connection. Returns the pause before the next try, or nothing if no try can succeed.
  std::optional<Duration> failed(const Error& why);
  void status_changed(const std::string& status);
  void publish();
  void log_failure(const Error& why, bool was_connected);
  void say(wire::LimitedLog::Topic topic, wire::LimitedLog::Severity severity, std::string_view text);
  /// Adds the address to an error that does not contain it.
  Error with_address(const Error& error) const;

  std::string address_;
  std::size_t slot_;
  CameraStates& states_;
  wire::LimitedLog& log_;
  Connect connect_;
  Begin begin_;
  std::function<void(const std::string&)> on_status_;
  std::unique_ptr<FrameSource> source_;  // Null between connections.
  AvailabilityTracker availability_;
  std::string camera_;  // The camera's name, known from the first connection on.
  Availability published_ = Availability::kAwaited;
  std::string published_reason_;
};

}  // namespace copresence::stream
