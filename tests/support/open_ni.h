#pragma once

// OpenNI2 for tests that use it without a frame source.

#include <OpenNI.h>
#include <dlfcn.h>

namespace copresence::testing {

/// Does what openni::OpenNI::initialize() does. It also keeps OpenNI2's player loaded until the
/// process ends, so that leak reports can name its functions (tests/lsan_suppressions.txt).
inline openni::Status start_open_ni() {
  const openni::Status status = openni::OpenNI::initialize();
  ::dlopen("libOniFile.so.0", RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
  return status;
}

}  // namespace copresence::testing
