#pragma once

// Stream descriptions as bytes in a file, such as a session recording. The bytes are a version and
// the body of a Welcome message. Thread: pure functions.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/stream_description.h"
#include "common/result.h"

namespace copresence::wire {

/// The oldest protocol version whose Welcome has today's layout. If the layout changes, set this to
/// kProtocolVersion.
inline constexpr std::uint32_t kOldestStoredVersion = 7;

/// Requires a description from a received Welcome, or another one that check() accepts.
std::vector<std::uint8_t> store_description(const StreamDescription& description);

/// Checks every number and text. Fails with kUnsupported for bytes of another release, and with
/// kCorrupt for damaged ones.
Result<StreamDescription> load_description(std::span<const std::uint8_t> bytes);

}  // namespace copresence::wire
