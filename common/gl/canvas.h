#pragma once

// A picture in graphics memory for libraries that draw by themselves. Parts of it are copied to other
// framebuffers, which is much cheaper in software than drawing them again. Row 0 is at the bottom,
// as in OpenGL's window coordinates. Thread: only the thread of its context (context.h).

#include <cstdint>

#include "common/gl/name.h"
#include "common/gl/texture.h"

namespace copresence::gl {

class Canvas {
 public:
  /// Requires width and height from 1 to 16384.
  Canvas(Context& context, int width, int height);

  int width() const { return texture_.width(); }
  int height() const { return texture_.height(); }

  /// Makes the canvas the target of drawing, and clears it.
  void begin();

  /// Copies a rectangle to the same place of another framebuffer. Pixels outside either picture are
  /// left out.
  void copy(int left, int bottom, int width, int height, std::uint32_t framebuffer) const;

 private:
  Texture texture_;
  Name<delete_framebuffer> framebuffer_;
};

}  // namespace copresence::gl
