#include "common/wire/clock_offset.h"

#include <algorithm>
#include <cassert>
#include <fstream>
#include <iterator>
#include <string>

namespace copresence::wire {
namespace {

// Number of pings that are kept. They cover about a minute at one ping a second.
constexpr std::size_t kSamples = 64;

/// Returns the largest possible drift between two quartz clocks: 50 ppm each.
Duration drift(Duration age) {
  return age / 10000;
}

std::string content(const char* path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

void ClockEstimate::add(Instant sent, Instant server_time, Instant received) {
  assert(sent <= received);
  const Duration half = (received - sent) / 2;
  samples_.push_back({received, server_time - (sent + half), half});
  if (samples_.size() > kSamples) samples_.pop_front();
}

ClockOffset ClockEstimate::at(Instant now) const {
  assert(!samples_.empty());
  const auto bound = [now](const Sample& sample) {
    return sample.half_round_trip + drift(now - sample.received);
  };
  const auto best = std::min_element(samples_.begin(), samples_.end(),
                                     [&](const Sample& a, const Sample& b) { return bound(a) < bound(b); });
  return {best->offset, bound(*best)};
}

std::uint64_t monotonic_clock_id() {
  const std::string boot = content("/proc/sys/kernel/random/boot_id");
  if (boot.empty()) return 0;
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a hash.
  for (const char c : boot + content("/proc/self/timens_offsets")) {
    hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3;
  }
  return hash ? hash : 1;
}

}  // namespace copresence::wire
