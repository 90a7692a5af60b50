#include "common/gl/timestamp.h"

#include <epoxy/gl.h>

#include <cassert>

#include "common/gl/context.h"

namespace copresence::gl {

Timestamp::Timestamp([[maybe_unused]] Context& context) {
  assert(context.is_on_its_thread());
  GLuint id = 0;
  glCreateQueries(GL_TIMESTAMP, 1, &id);
  name_ = Name<delete_query>(id);
}

void Timestamp::record() {
  glQueryCounter(name_.id(), GL_TIMESTAMP);
}

std::chrono::nanoseconds Timestamp::read() const {
  GLint64 value = 0;
  glGetQueryObjecti64v(name_.id(), GL_QUERY_RESULT, &value);
  return std::chrono::nanoseconds(value);
}

}  // namespace copresence::gl
