#pragma once

// The reasons in EndOfStream after which a server does not come back by itself: it has sent what it was asked
// to send. After any other reason a client may expect the server to be started again.

#include <string_view>

namespace copresence::wire {

inline constexpr std::string_view kRecordingIsOver = "the recording is over";
inline constexpr std::string_view kAllFramesAreSent = "all frames that --frames asked for are sent";

inline bool ends_for_good(std::string_view reason) {
  return reason == kRecordingIsOver || reason == kAllFramesAreSent;
}

}  // namespace copresence::wire
