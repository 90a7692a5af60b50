#pragma once

// Writes the log lines about a server's connections and limits their number.
//
// Each client that joins or leaves is one line, at most kLines of them per kPeriod. At the end of a
// period, one line has the number of further clients that joined and left. Another line has the
// number of connections that ended before they acknowledged a frame, the reasons, and the network
// of most of them. Thread: a value.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

/// Why a connection ended.
enum class Ending {
  kHungUp,        ///< the peer or the network closed it
  kNoHello,       ///< sent no Hello in time
  kNonsense,      ///< violated the protocol
  kSilent,        ///< sent nothing and received nothing for too long
  kNoProgress,    ///< acknowledged no frame in time
  kMadeRoom,      ///< closed to make room for another connection
  kNoPlace,       ///< the server has as many clients as it takes
  kOtherVersion,  ///< has another protocol version
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

  /// `clients` is their number now.
  void joined(const std::string& address, std::size_t clients, Instant now);
  void left(const std::string& address, Ending why, Duration after, std::size_t clients, Instant now);
  /// A connection ended before its first acknowledgement.
  void ended_early(const std::string& network, Ending why, Instant now);

  /// Returns the lines that are due and forgets them.
  std::vector<Line> take(Instant now);

 private:
  void begin_period(Instant now);
  bool may_write(Instant now);

  std::vector<Line> due_;
  Instant period_ends_{};
  bool in_period_ = false;
  std::size_t written_ = 0;
  std::uint64_t joined_unwritten_ = 0, left_unwritten_ = 0;
  std::map<Ending, std::uint64_t> early_;
  std::map<std::string, std::uint64_t> early_by_network_;
  std::uint64_t early_total_ = 0;
};

}  // namespace copresence::wire
