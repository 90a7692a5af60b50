#pragma once

// A linked shader program: a compute shader, or a vertex and a fragment shader. Thread: only the
// thread of its context (context.h).

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/gl/name.h"
#include "common/result.h"

namespace copresence::gl {

class Buffer;
class Context;

/// A `#define name value` line, inserted after the shader's #version line.
struct Define {
  std::string_view name;
  std::string value;
};

/// OpenGL's DispatchIndirectCommand, which dispatch_indirect() reads.
struct DispatchCommand {
  std::uint32_t groups_x = 0;
  std::uint32_t groups_y = 1;
  std::uint32_t groups_z = 1;
};

class Program {
 public:
  /// Sources must begin with `#version 450 core`. These functions fail with kInvalid and the
  /// compiler's log.
  static Result<Program> compute(Context& context, std::string_view source,
                                 std::span<const Define> defines = {});
  static Result<Program> graphics(Context& context, std::string_view vertex, std::string_view fragment,
                                  std::span<const Define> defines = {});

  /// Sets a uniform. Requires that a shader uses the uniform and that the types agree.
  void set(const char* uniform, int value);
  void set(const char* uniform, unsigned value);
  void set(const char* uniform, float value);
  void set(const char* uniform, const Eigen::Vector2i& value);
  void set(const char* uniform, const Eigen::Vector2f& value);
  void set(const char* uniform, const Eigen::Vector3f& value);
  void set(const char* uniform, const Eigen::Vector4f& value);
  void set(const char* uniform, const Eigen::Matrix3f& value);
  void set(const char* uniform, const Eigen::Matrix4f& value);
  void set(const char* uniform, const Eigen::Matrix<float, 3, 4>& value);  ///< A mat4x3 in GLSL.

  /// Runs a compute shader in this number of work groups.
  void dispatch(int groups_x, int groups_y = 1, int groups_z = 1) const;
  /// Runs at least one invocation per pixel. The shader must skip pixels outside.
  void dispatch_over(int width, int height) const;
  /// Runs a compute shader in the work groups of the DispatchCommand at byte `offset` of `command`.
  void dispatch_indirect(const Buffer& command, std::size_t offset = 0) const;

  std::uint32_t id() const { return name_.id(); }

 private:
  Program() = default;
  int location(const char* uniform) const;

  Name<delete_program> name_;
  int group_width_ = 0;  // Work group size of a compute shader.
  int group_height_ = 0;
};

}  // namespace copresence::gl
