#include "common/gl/program.h"

#include <epoxy/gl.h>

#include <array>
#include <cassert>
#include <utility>

#include "common/gl/buffer.h"
#include "common/gl/context.h"

namespace copresence::gl {
namespace {

struct Stage {
  GLenum kind;
  std::string_view source;
};

std::string trimmed(std::string log) {
  log.resize(std::char_traits<char>::length(log.c_str()));
  while (!log.empty() && (log.back() == '\n' || log.back() == ' ')) log.pop_back();
  return log;
}

std::string compile_log(GLuint shader) {
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(std::size_t(length) + 1, '\0');
  glGetShaderInfoLog(shader, GLsizei(log.size()), nullptr, log.data());
  return trimmed(std::move(log));
}

std::string link_log(GLuint program) {
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(std::size_t(length) + 1, '\0');
  glGetProgramInfoLog(program, GLsizei(log.size()), nullptr, log.data());
  return trimmed(std::move(log));
}

std::string with_defines(std::string_view source, std::span<const Define> defines) {
  assert(source.starts_with("#version"));
  const std::size_t line_end = source.find('\n') + 1;
  std::string text(source.substr(0, line_end));
  for (const Define& define : defines) {
    text += "#define " + std::string(define.name) + " " + define.value + "\n";
  }
  text += "#line 2\n";  // Makes the compiler's log use the line numbers of the file.
  text += source.substr(line_end);
  return text;
}

// Compiles a shader and attaches it to `program`, which keeps it.
Result<void> attach(GLuint program, const Stage& stage, std::span<const Define> defines) {
  const GLuint shader = glCreateShader(stage.kind);
  const std::string text = with_defines(stage.source, defines);
  const char* lines = text.c_str();
  glShaderSource(shader, 1, &lines, nullptr);
  glCompileShader(shader);
  GLint compiled = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (!compiled) {
    const std::string log = compile_log(shader);
    glDeleteShader(shader);
    return fail(ErrorCode::kInvalid, "a shader does not compile: " + log);
  }
  glAttachShader(program, shader);
  glDeleteShader(shader);
  return {};
}

Result<Name<delete_program>> build(std::span<const Stage> stages, std::span<const Define> defines) {
  Name<delete_program> program(glCreateProgram());
  for (const Stage& stage : stages) {
    if (const auto attached = attach(program.id(), stage, defines); !attached) return fail(attached.error());
  }
  glLinkProgram(program.id());
  GLint linked = 0;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &linked);
  if (!linked) return fail(ErrorCode::kInvalid, "a shader does not link: " + link_log(program.id()));
  return program;
}

}  // namespace

Result<Program> Program::compute([[maybe_unused]] Context& context, std::string_view source,
                                 std::span<const Define> defines) {
  assert(context.is_on_its_thread());
  auto name = build(std::array{Stage{GL_COMPUTE_SHADER, source}}, defines);
  if (!name) return fail(name.error());
  Program program;
  program.name_ = std::move(*name);
  std::array<GLint, 3> group{};
  glGetProgramiv(program.id(), GL_COMPUTE_WORK_GROUP_SIZE, group.data());
  program.group_width_ = group[0];
  program.group_height_ = group[1];
  return program;
}

Result<Program> Program::graphics([[maybe_unused]] Context& context, std::string_view vertex,
                                  std::string_view fragment, std::span<const Define> defines) {
  assert(context.is_on_its_thread());
  auto name =
      build(std::array{Stage{GL_VERTEX_SHADER, vertex}, Stage{GL_FRAGMENT_SHADER, fragment}}, defines);
  if (!name) return fail(name.error());
  Program program;
  program.name_ = std::move(*name);
  return program;
}

int Program::location(const char* uniform) const {
  const GLint location = glGetUniformLocation(id(), uniform);
  assert(location >= 0 && "a shader uses the uniform");
  return location;
}

void Program::set(const char* uniform, int value) {
  glProgramUniform1i(id(), location(uniform), value);
}

void Program::set(const char* uniform, unsigned value) {
  glProgramUniform1ui(id(), location(uniform), value);
}

void Program::set(const char* uniform, float value) {
  glProgramUniform1f(id(), location(uniform), value);
}

void Program::set(const char* uniform, const Eigen::Vector2i& value) {
  glProgramUniform2iv(id(), location(uniform), 1, value.data());
}

void Program::set(const char* uniform, const Eigen::Vector2f& value) {
  glProgramUniform2fv(id(), location(uniform), 1, value.data());
}

void Program::set(const char* uniform, const Eigen::Vector3f& value) {
  glProgramUniform3fv(id(), location(uniform), 1, value.data());
}

void Program::set(const char* uniform, const Eigen::Vector4f& value) {
  glProgramUniform4fv(id(), location(uniform), 1, value.data());
}

void Program::set(const char* uniform, const Eigen::Matrix3f& value) {
  glProgramUniformMatrix3fv(id(), location(uniform), 1, GL_FALSE, value.data());
}

void Program::set(const char* uniform, const Eigen::Matrix4f& value) {
  glProgramUniformMatrix4fv(id(), location(uniform), 1, GL_FALSE, value.data());
}

void Program::set(const char* uniform, const Eigen::Matrix<float, 3, 4>& value) {
  glProgramUniformMatrix4x3fv(id(), location(uniform), 1, GL_FALSE, value.data());
}

void Program::dispatch(int groups_x, int groups_y, int groups_z) const {
  assert(group_width_ > 0 && groups_x >= 0 && groups_y >= 0 && groups_z >= 0);
  glUseProgram(id());
  glDispatchCompute(GLuint(groups_x), GLuint(groups_y), GLuint(groups_z));
}

void Program::dispatch_over(int width, int height) const {
  assert(group_width_ > 0 && width >= 0 && height >= 0);
  dispatch((width + group_width_ - 1) / group_width_, (height + group_height_ - 1) / group_height_);
}

void Program::dispatch_indirect(const Buffer& command, std::size_t offset) const {
  assert(group_width_ > 0);
  glUseProgram(id());
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, command.id());
  glDispatchComputeIndirect(GLintptr(offset));
}

}  // namespace copresence::gl
