#include "common/wire/connection_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace copresence::wire {
namespace {

constexpr std::size_t kNetworks = 1000;  // Limit of the networks counted in one period.

const char* in_words(Ending why) {
  switch (why) {
    case Ending::kHungUp:
      return "hung up";
    case Ending::kNoHello:
      return "sent no hello";
    case Ending::kNoKey:
      return "came without the room's key";
    case Ending::kWrongKey:
      return "had another room key";
    case Ending::kUnexpectedKey:
      return "had a room key, which this server has not";
    case Ending::kNonsense:
      return "violated the protocol";
    case Ending::kSilent:
      return "sent and received nothing for too long";
    case Ending::kNoProgress:
      return "acknowledged no frame";
    case Ending::kMadeRoom:
      return "made room for others";
    case Ending::kNoPlace:
      return "found the server full";
    case Ending::kOtherVersion:
      return "had another protocol version";
    case Ending::kNoToken:
      return "had no valid token";
    case Ending::kServerEnds:
      return "were open when the server stopped";
  }
  return "";
}

std::string counted(std::uint64_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace

void ConnectionLog::begin_period(Instant now) {
  if (std::exchange(in_period_, true)) return;
  period_ends_ = now + kPeriod;
  written_ = 0;
}

bool ConnectionLog::may_write(Instant now) {
  begin_period(now);
  return written_ < kLines && ++written_;
}

void ConnectionLog::joined(const std::string& address, std::size_t clients, Instant now) {
  if (!may_write(now)) {
    ++joined_unwritten_;
    return;
  }
  due_.push_back({false, fmt::format("viewer {} connected ({} now)", address, clients)});
}

void ConnectionLog::left(const std::string& address, Ending why, Duration after, std::size_t clients,
                         Instant now) {
  if (!may_write(now)) {
    ++left_unwritten_;
    return;
  }
  const bool by_itself = why == Ending::kHungUp || why == Ending::kServerEnds;
  due_.push_back({!by_itself, fmt::format("viewer {} left after {:.0f} s{} ({} now)", address,
                                          std::chrono::duration<double>(after).count(),
                                          by_itself ? "" : fmt::format(": it {}", in_words(why)), clients)});
}

void ConnectionLog::ended_early(const std::string& network, Ending why, Instant now) {
  begin_period(now);
  ++early_[why];
  ++early_total_;
  if (early_by_network_.size() < kNetworks || early_by_network_.contains(network))
    ++early_by_network_[network];
}

std::vector<ConnectionLog::Line> ConnectionLog::take(Instant now) {
  std::vector<Line> lines = std::exchange(due_, {});
  if (!in_period_ || now < period_ends_) return lines;
  in_period_ = false;
  if (joined_unwritten_ + left_unwritten_ > 0) {
    lines.push_back(
        {false, fmt::format("{} connected and {} left in the last {} s",
                            counted(joined_unwritten_, "more viewer"), left_unwritten_, kPeriod.count())});
  }
  if (early_total_ > 0) {
    std::string reasons;
    for (const auto& [why, count] : early_) {
      reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, in_words(why));
    }
    const auto most = std::max_element(early_by_network_.begin(), early_by_network_.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    lines.push_back(
        {true,
         fmt::format("{} in the last {} s ended before the first frame was acknowledged: {}; {} came from {}",
                     counted(early_total_, "connection"), kPeriod.count(), reasons, most->second,
                     most->first)});
  }
  joined_unwritten_ = left_unwritten_ = early_total_ = 0;
  early_.clear();
  early_by_network_.clear();
  return lines;
}

}  // namespace copresence::wire
