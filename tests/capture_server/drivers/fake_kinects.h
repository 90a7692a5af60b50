#pragma once

// A bus of Kinects that the fake libfreenect shows: for each a file, named by its serial number, with the words of what is wrong
// with it (tests/support/fake_freenect).

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/process.h"

namespace copresence::testing {

class FakeKinects : public ::testing::Test {
 protected:
  FakeKinects() { ::setenv("COPRESENCE_FAKE_KINECTS", (folder_ / "").string().c_str(), 1); }

  void plug_in(const std::string& serial, const std::string& faults = "") const {
    std::ofstream(folder_ / serial) << faults;
  }
  void unplug(const std::string& serial) const { std::filesystem::remove(folder_ / serial); }

 private:
  TemporaryFolder folder_;
};

}  // namespace copresence::testing
