#pragma once

// A camera that may disappear and return. A camera that was unplugged, fell silent or had failing
// transfers is opened again and again until that succeeds. Sequence numbers continue.
// Thread: as FrameSource.

#include <functional>
#include <memory>

#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {

class ReconnectingSource final : public FrameSource {
 public:
  using Open = std::function<Result<std::unique_ptr<FrameSource>>()>;

  /// Time between two attempts to open a missing camera. A camera must be back within a second.
  static constexpr std::chrono::milliseconds kBetweenTries{250};

  /// Fails as `open` does. A camera that is missing at the first attempt is an error.
  static Result<std::unique_ptr<FrameSource>> open(Open open,
                                                   std::chrono::milliseconds between_tries = kBetweenTries);

  const SensorDescription& description() const override { return description_; }
  SourceCounters counters() const override;

  /// As FrameSource::next(). After kUnavailable and kTimeout, call next() again. The next call
  /// tries once to open the camera and waits for its first frame, together up to 20 s.
  /// Fails with kUnsupported if a different kind of camera came back.
  Result<RgbdFrame> next(std::stop_token stop) override;

 private:
  ReconnectingSource(std::unique_ptr<FrameSource> first, Open open, std::chrono::milliseconds between_tries);

  const Open open_;
  const std::chrono::milliseconds between_tries_;
  const SensorDescription description_;
  std::unique_ptr<FrameSource> source_;  // The pointer is null while the camera is absent.
  SourceCounters before_;                // Sums of the counters of all closed sources.
};

}  // namespace copresence::sensor
