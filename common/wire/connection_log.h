#pragma once

// Writes the log lines about a server's connections and limits their number.
//
// Each client that joins or leaves gets one line, up to kLines per kPeriod. At the end of a period,
// one line counts the further clients that joined and left. Another line counts the connections
// that ended before they acknowledged a frame, with reasons and main network. Thread: distinct
// objects are independent.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

enum class Ending {
  kHungUp,         ///< The peer or the network closed it.
  kNoHello,        ///< The peer sent no Hello in time.
  kNoKey,          ///< The peer came without the room's key.
  kWrongKey,       ///< The peer has another room key.
  kUnexpectedKey,  ///< The peer has a room key, and this server has none.
  kNonsense,       ///< The peer violated the protocol.
  kSilent,         ///< No bytes were sent or received for too long.
  kNoProgress,     ///< The peer acknowledged no frame in time.
  kMadeRoom,       ///< The server closed it to make room for another connection.
  kNoPlace,        ///< The server has its maximum number of clients.
  kOtherVersion,   ///< The peer has another protocol version.
  kNoToken,        ///< The peer has no valid token of the web gateway.
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

  void joined(const std::string& address, std::size_t clients, Instant now);
  void left(const std::string& address, Ending why, Duration after, std::size_t clients, Instant now);
  /// Counts a connection that ended before its first acknowledgement.
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
