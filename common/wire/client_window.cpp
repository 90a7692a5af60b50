#include "common/wire/client_window.h"

#include <algorithm>
#include <cassert>

namespace copresence::wire {

void ClientWindow::sent(std::uint64_t sequence, std::size_t bytes) {
  assert(has_room());
  in_flight_.push_back({sequence, bytes});
  bytes_ += bytes;
  in_step_ = true;
}

void ClientWindow::skip(std::uint64_t frames) {
  if (frames == 0) return;
  skipped_ += frames;
  in_step_ = false;
}

bool ClientWindow::acknowledge(std::uint64_t sequence) {
  const auto known = std::find_if(in_flight_.begin(), in_flight_.end(),
                                  [sequence](const Frame& frame) { return frame.sequence == sequence; });
  if (known == in_flight_.end()) return false;
  const auto arrived = known + 1;
  for (auto frame = in_flight_.begin(); frame != arrived; ++frame) bytes_ -= frame->bytes;
  in_flight_.erase(in_flight_.begin(), arrived);
  return true;
}

}  // namespace copresence::wire
