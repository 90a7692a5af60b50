#pragma once

// An owner of libfreenect's context, and access to libfreenect's messages, because libfreenect
// reports the reason of a failure only in its log.
// Thread: one thread at a time per context.

#include <libfreenect.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace copresence::drivers {

struct ShutDownFreenect {
  void operator()(freenect_context* context) const { freenect_shutdown(context); }
};
using FreenectContext = std::unique_ptr<freenect_context, ShutDownFreenect>;

/// Returns null if USB cannot be used at all. `parts` is a mask of freenect_device_flags.
FreenectContext make_freenect_context(int parts);

/// The last error that libfreenect logged on this thread, on one line, or "no reason given".
std::string last_freenect_error();

/// Serial numbers of the Kinects that report one. Returns nothing if USB fails.
std::optional<std::vector<std::string>> list_serials(freenect_context& context);

}  // namespace copresence::drivers
