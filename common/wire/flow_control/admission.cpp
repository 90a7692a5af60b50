#include "common/wire/flow_control/admission.h"

#include <algorithm>
#include <map>
#include <string_view>

namespace copresence::wire {
namespace {

constexpr std::size_t kPlaces = 32, kNewcomers = 64, kStrangers = 128;
constexpr std::chrono::seconds kStalled{10};

std::optional<std::size_t> oldest_of_largest_network(Stage stage, const std::string& newest_network,
                                                     std::span<const Standing> others) {
  std::map<std::string_view, std::size_t> members = {{newest_network, 1}};
  for (const Standing& other : others) {
    if (other.stage == stage) ++members[other.network];
  }
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (others[i].stage != stage) continue;
    if (!chosen) {
      chosen = i;
      continue;
    }
    const std::size_t here = members[others[i].network], there = members[others[*chosen].network];
    if (here > there || (here == there && others[i].since < others[*chosen].since)) chosen = i;
  }
  return chosen;
}

std::optional<std::size_t> longest_stalled_client(std::span<const Standing> others, Instant now) {
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto& waits_since = others[i].waits_since;
    if (others[i].stage != Stage::kClient || !waits_since || now - *waits_since < kStalled) continue;
    if (!chosen || *waits_since < *others[*chosen].waits_since) chosen = i;
  }
  return chosen;
}

}  // namespace

std::size_t room_for(Stage stage) {
  switch (stage) {
    case Stage::kStranger:
      return kStrangers;
    case Stage::kNewcomer:
      return kNewcomers;
    case Stage::kClient:
      return kPlaces;
  }
  return 0;
}

Decision admit(Stage stage, const std::string& network, std::span<const Standing> others, Instant now) {
  const auto members = static_cast<std::size_t>(std::count_if(
      others.begin(), others.end(), [stage](const Standing& other) { return other.stage == stage; }));
  if (members < room_for(stage)) return {true, std::nullopt};
  if (stage != Stage::kClient) return {true, oldest_of_largest_network(stage, network, others)};
  const auto stalled = longest_stalled_client(others, now);
  return {stalled.has_value(), stalled};
}

}  // namespace copresence::wire
