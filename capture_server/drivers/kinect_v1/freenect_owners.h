#pragma once

// An owner of libfreenect's context, and libfreenect's messages. libfreenect reports the reason of
// a failure only in its log.
//
// Thread: one context is used by one thread at a time.

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

/// Null if USB cannot be used at all. `parts`: of freenect_device_flags.
FreenectContext make_freenect_context(int parts);

/// The last error that libfreenect logged on this thread, on one line; "no reason given" if there
/// was none.
std::string last_freenect_error();

/// Serial numbers of the Kinects that report one; nothing if the bus cannot be read now.
std::optional<std::vector<std::string>> list_serials(freenect_context& context);

}  // namespace copresence::drivers
