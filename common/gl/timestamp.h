#pragma once

// When the graphics card got to a place in the command stream. Times of work are differences of two of these:
// elapsed-time queries are wrong in Mesa's software rasteriser.

#include <chrono>

#include "common/gl/name.h"

namespace copresence::gl {

class Context;

class Timestamp {
 public:
  explicit Timestamp(Context& context);

  /// Marks this place; a mark made earlier is forgotten.
  void record();

  /// Since an arbitrary zero of the device. Waits until the card got there. Requires record() before.
  std::chrono::nanoseconds read() const;

 private:
  Name<delete_query> name_;
};

}  // namespace copresence::gl
