#include "render_client/viewpoint/tracker_report.h"

#include <fmt/format.h>

#include <utility>

namespace copresence::viewpoint {

void TrackerReport::took_pose(Instant now) {
  pose_is_unsaid_ = pose_is_unsaid_ || !has_pose_ || is_silent_;
  has_pose_ = true;
  is_silent_ = false;
  heard_at_ = now;
}

void TrackerReport::refused(DatagramFault fault, std::span<const std::uint8_t> received, std::size_t size,
                            Instant now) {
  heard_at_ = now;
  Kind& kind = kinds_[static_cast<std::size_t>(fault)];
  ++kind.unsaid;
  if (kind.latest.empty() && may_say(kind.said_at, now)) kind.latest = describe(fault, received, size);
}

std::optional<News> TrackerReport::next(Instant now) {
  if (!began_at_) began_at_ = now;
  if (std::exchange(pose_is_unsaid_, false)) return News{false, fmt::format("{}: poses arrive", where())};
  for (Kind& kind : kinds_) {
    if (kind.latest.empty()) continue;
    kind.said_at = now;
    return News{
        true,
        fmt::format("{}: ignores {} ({} such); expected are {} (opentrack's output \"UDP over network\")",
                    where(), std::exchange(kind.latest, {}), std::exchange(kind.unsaid, 0),
                    expected_datagram())};
  }
  if (is_silent_ || now - heard_at_.value_or(*began_at_) < kSilence || !may_say(silence_said_at_, now)) {
    return std::nullopt;
  }
  is_silent_ = true;
  silence_said_at_ = now;
  if (heard_at_) {
    return News{true, fmt::format("{}: nothing has come for {} s; the view stays where it is", where(),
                                  kSilence.count())};
  }
  return News{
      true,
      fmt::format("{}: nothing has come in {} s; in opentrack choose the output \"UDP over network\" to "
                  "127.0.0.1, port {}, and press Start (docs/guide/viewing.md)",
                  where(), kSilence.count(), port_)};
}

std::string TrackerReport::where() const {
  return fmt::format("head tracker, UDP port {}", port_);
}

}  // namespace copresence::viewpoint
