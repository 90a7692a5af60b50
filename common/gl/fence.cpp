#include "common/gl/fence.h"

#include <epoxy/gl.h>

#include <cassert>

#include "common/gl/context.h"

namespace copresence::gl {

void FenceDeleter::operator()(__GLsync* sync) const noexcept {
  glDeleteSync(sync);
}

Fence::Fence([[maybe_unused]] Context& context) : sync_(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)) {
  assert(context.is_on_its_thread());
  glFlush();
}

bool Fence::wait(std::chrono::nanoseconds timeout) const {
  const GLenum answer = glClientWaitSync(sync_.get(), 0, GLuint64(timeout.count()));
  return answer == GL_ALREADY_SIGNALED || answer == GL_CONDITION_SATISFIED;
}

}  // namespace copresence::gl
