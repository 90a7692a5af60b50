#pragma once

// A compute shader, or a vertex and a fragment shader, compiled and linked. A class of ours that draws wraps
// one of these: its setters are the uniforms, so that a uniform's name stands in one place.

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

/// `#define name value`, put behind the shader's #version line.
struct Define {
  std::string_view name;
  std::string value;
};

/// What dispatch_indirect() reads; OpenGL's DispatchIndirectCommand.
struct DispatchCommand {
  std::uint32_t groups_x = 0;
  std::uint32_t groups_y = 1;
  std::uint32_t groups_z = 1;
};

class Program {
 public:
  /// Requires sources that begin with `#version 450 core`.
  /// Fails  kInvalid with the compiler's log.
  static Result<Program> compute(Context& context, std::string_view source,
                                 std::span<const Define> defines = {});
  static Result<Program> graphics(Context& context, std::string_view vertex, std::string_view fragment,
                                  std::span<const Define> defines = {});

  /// Requires that a shader uses the uniform and that its type is the value's.
  void set(const char* uniform, int value);
  void set(const char* uniform, unsigned value);
  void set(const char* uniform, float value);
  void set(const char* uniform, const Eigen::Vector2i& value);
  void set(const char* uniform, const Eigen::Vector2f& value);
  void set(const char* uniform, const Eigen::Vector3f& value);
  void set(const char* uniform, const Eigen::Vector4f& value);
  void set(const char* uniform, const Eigen::Matrix3f& value);
  void set(const char* uniform, const Eigen::Matrix4f& value);
  void set(const char* uniform, const Eigen::Matrix<float, 3, 4>& value);  ///< GLSL's mat4x3

  /// Runs a compute shader in so many groups.
  void dispatch(int groups_x, int groups_y = 1, int groups_z = 1) const;
  /// Runs it with at least one invocation per pixel; those outside are the shader's to skip.
  void dispatch_over(int width, int height) const;
  /// Runs it in the groups that a DispatchCommand at byte `offset` of a buffer names.
  void dispatch_indirect(const Buffer& command, std::size_t offset = 0) const;

  std::uint32_t id() const { return name_.id(); }

 private:
  Program() = default;
  int location(const char* uniform) const;

  Name<delete_program> name_;
  int group_width_ = 0;  // of a compute shader
  int group_height_ = 0;
};

}  // namespace copresence::gl
