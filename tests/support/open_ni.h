#pragma once

// OpenNI2, for tests that use it without a frame source.

#include <OpenNI.h>
#include <dlfcn.h>

namespace copresence::testing {

/// As openni::OpenNI::initialize(). Its player of recordings then stays loaded to the end of the process, so that reports of
/// what it leaks know what to call it (tests/lsan_suppressions.txt).
inline openni::Status start_open_ni() {
  const openni::Status status = openni::OpenNI::initialize();
  ::dlopen("libOniFile.so.0", RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
  return status;
}

}  // namespace copresence::testing
