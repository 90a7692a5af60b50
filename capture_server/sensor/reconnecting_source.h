#pragma once

// A camera that may go and come back: unplugged, silent or with failing transfers it is opened again until it
// is there, and its frames go on counting.
//
// Thread: as FrameSource.

#include <functional>
#include <memory>

#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {

class ReconnectingSource final : public FrameSource {
 public:
  using Open = std::function<Result<std::unique_ptr<FrameSource>>()>;

  /// How often a missing camera is looked for: it must be back within a second of being plugged in.
  static constexpr std::chrono::milliseconds kBetweenTries{250};

  /// Fails  as `open`, the first time: a camera that was never there is a mistake on the command line.
  static Result<std::unique_ptr<FrameSource>> open(Open open,
                                                   std::chrono::milliseconds between_tries = kBetweenTries);

  const SensorDescription& description() const override { return description_; }
  SourceCounters counters() const override;

  /// As FrameSource::next(), but after kUnavailable and kTimeout call it again. That call looks for the
  /// camera once and may open it, which takes a slow one up to 20 s, and waits for its first frame. Fails
  /// with kUnsupported when what came back is another kind of camera.
  Result<RgbdFrame> next(std::stop_token stop) override;

 private:
  ReconnectingSource(std::unique_ptr<FrameSource> first, Open open, std::chrono::milliseconds between_tries);

  const Open open_;
  const std::chrono::milliseconds between_tries_;
  const SensorDescription description_;
  std::unique_ptr<FrameSource> source_;  // null while it is away
  SourceCounters before_;                // of those that are gone
};

}  // namespace copresence::sensor
