#pragma once

// Draws triangles into colour textures and a depth texture of the same size. Vertices have no
// attributes: shaders fetch their data from textures by gl_VertexID. Thread: only the thread of its
// context (context.h).

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "common/gl/name.h"

namespace copresence::gl {

class Buffer;
class Context;
class Program;
class Texture;

/// OpenGL's DrawElementsIndirectCommand, which draw_indirect() reads.
struct DrawCommand {
  std::uint32_t indices = 0;
  std::uint32_t instances = 1;
  std::uint32_t first_index = 0;
  std::int32_t base_vertex = 0;
  std::uint32_t base_instance = 0;
};

class Framebuffer {
 public:
  /// Colour attachment i is `colors[i]`; `depth` may be null. If the textures have layers, layer
  /// `layer` is drawn into. Requires textures of equal size that outlive the framebuffer.
  Framebuffer(Context& context, std::initializer_list<const Texture*> colors, const Texture* depth,
              int layer = 0);

  int width() const { return width_; }
  int height() const { return height_; }

  void clear_color(int attachment, const std::array<float, 4>& value);
  void clear_integers(int attachment, const std::array<std::uint32_t, 4>& value);  ///< For integer formats.
  void clear_depth(float value);

  /// Sets whether triangles are drawn as lines along their sides. They are filled at first.
  void draw_lines(bool lines) { draws_lines_ = lines; }

  /// Draws triangles. `indices` holds std::uint32_t, and `command` holds a DrawCommand at byte
  /// `offset`. With a depth texture, the fragment with the smaller depth wins. Only front faces are
  /// drawn: triangles with counter-clockwise corners in clip coordinates, y up.
  void draw_indirect(const Program& program, const Buffer& indices, const Buffer& command,
                     std::size_t offset = 0);

  /// Draws vertices / 3 triangles without indices, by the same rules as draw_indirect().
  void draw(const Program& program, int vertices);

 private:
  void begin(const Program& program);

  Name<delete_framebuffer> name_;
  std::uint32_t vertex_array_;  // The vertex array of the context.
  int width_ = 0;
  int height_ = 0;
  bool has_depth_;
  bool draws_lines_ = false;
};

}  // namespace copresence::gl
