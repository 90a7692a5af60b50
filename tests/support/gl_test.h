#pragma once

// The fixture of all tests that need OpenGL. Each test gets a headless debug context, and any
// complaint of the driver fails the test. Without OpenGL the tests are skipped with a message. On
// CI, Context.ExistsOnCi fails instead.

#include <gtest/gtest.h>

#include <iostream>
#include <memory>
#include <string>

#include "common/gl/context.h"

namespace copresence::gl {

class GlTest : public testing::Test {
 protected:
  void SetUp() override {
    auto made = Context::headless(Debug::kOn);
    if (!made) {
      std::cerr << "*** SKIPPED, NOT TESTED: " << made.error().what << " ***\n";
      GTEST_SKIP() << made.error().what;
    }
    context_ = std::move(*made);
  }

  void TearDown() override {
    if (!context_) return;
    for (const std::string& error : context_->take_errors()) ADD_FAILURE() << "OpenGL: " << error;
  }

  Context& context() { return *context_; }

 private:
  std::unique_ptr<Context> context_;
};

}  // namespace copresence::gl
