#pragma once

// Turns what happens to a server's connections into a few lines for its log, however much happens.
//
// A client that comes or leaves is one line each, at most kLines of them in kPeriod. Connections that ended
// before they acknowledged a frame are counted. At the end of a period one line says how many there were, why
// they ended, and which network most of them came from, and one says how many clients came and left beyond
// those that have lines.
//
// Thread: a value.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

/// Why a connection ended.
enum class Ending {
  kHungUp,        ///< the other end closed it, or the network did
  kNoHello,       ///< said no hello in time
  kNonsense,      ///< sent what no client sends
  kSilent,        ///< nothing came from it, and nothing arrived there
  kNoProgress,    ///< acknowledged no frame in time
  kMadeRoom,      ///< closed for somebody else
  kNoPlace,       ///< all places are taken
  kOtherVersion,  ///< another release
  kServerEnds,
};

class ConnectionLog {
 public:
  static constexpr std::size_t kLines = 10;
  static constexpr std::chrono::seconds kPeriod{10};

  struct Line {
    bool is_warning = false;
    std::string text;
  };

  /// `clients` are all there are now.
  void came(const std::string& address, std::size_t clients, Instant now);
  void left(const std::string& address, Ending why, Duration after, std::size_t clients, Instant now);
  /// A connection ended before its first acknowledgement.
  void ended_early(const std::string& network, Ending why, Instant now);

  /// The lines that are due, each once.
  std::vector<Line> take(Instant now);

 private:
  void begin_period(Instant now);
  bool may_say(Instant now);

  std::vector<Line> due_;
  Instant period_ends_{};
  bool in_period_ = false;
  std::size_t said_ = 0;
  std::uint64_t came_unsaid_ = 0, left_unsaid_ = 0;
  std::map<Ending, std::uint64_t> early_;
  std::map<std::string, std::uint64_t> early_by_network_;
  std::uint64_t early_total_ = 0;
};

}  // namespace copresence::wire
