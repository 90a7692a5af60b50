#include "common/gl/context.h"

// epoxy/gl.h must come before epoxy/egl.h.
#include <epoxy/gl.h>
//
#include <epoxy/egl.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>

namespace copresence::gl {
namespace {

constexpr std::size_t kErrorsKept = 32;

// Counts the users of EGL's displays, since eglTerminate() ends a display for all its users.
class Displays {
 public:
  static bool open(EGLDisplay display) {
    const std::lock_guard lock(mutex());
    if (!eglInitialize(display, nullptr, nullptr)) return false;
    ++users()[display];
    return true;
  }
  static void close(EGLDisplay display) {
    const std::lock_guard lock(mutex());
    if (--users()[display] > 0) return;
    users().erase(display);
    eglTerminate(display);
  }

 private:
  static std::mutex& mutex() {
    static std::mutex mutex;
    return mutex;
  }
  static std::map<EGLDisplay, int>& users() {
    static std::map<EGLDisplay, int> users;
    return users;
  }
};

// Returns hardware devices, then Mesa's software renderer without a device, then software devices.
std::vector<EGLDisplay> candidate_displays() {
  std::vector<EGLDisplay> hardware, software, surfaceless;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
      epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    eglQueryDevicesEXT(EGLint(devices.size()), devices.data(), &count);
    for (EGLint i = 0; i < count; ++i) {
      const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
      if (display == EGL_NO_DISPLAY) continue;
      const char* extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
      const bool is_software = extensions && std::strstr(extensions, "EGL_MESA_device_software");
      (is_software ? software : hardware).push_back(display);
    }
  }
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    const EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display != EGL_NO_DISPLAY) surfaceless.push_back(display);
  }
  std::vector<EGLDisplay> all = std::move(hardware);
  all.insert(all.end(), surfaceless.begin(), surfaceless.end());
  all.insert(all.end(), software.begin(), software.end());
  return all;
}

// Creates a 4.5 core context without a surface. Returns EGL_NO_CONTEXT if that fails.
EGLContext make_current_context(EGLDisplay display, Debug debug) {
  if (!eglBindAPI(EGL_OPENGL_API)) return EGL_NO_CONTEXT;
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!epoxy_has_egl_extension(display, "EGL_KHR_no_config_context")) {
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                             EGL_NONE};
    EGLint found = 0;
    if (!eglChooseConfig(display, wanted, &config, 1, &found) || found == 0) return EGL_NO_CONTEXT;
  }
  const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                           4,
                           EGL_CONTEXT_MINOR_VERSION,
                           5,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_CONTEXT_OPENGL_DEBUG,
                           debug == Debug::kOn ? EGL_TRUE : EGL_FALSE,
                           EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, wanted);
  if (context == EGL_NO_CONTEXT) return EGL_NO_CONTEXT;
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    eglDestroyContext(display, context);
    return EGL_NO_CONTEXT;
  }
  return context;
}

std::string text_of(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text ? text : "unknown";
}

void keep_error(std::vector<std::string>& errors, std::string error) {
  if (errors.size() < kErrorsKept) errors.push_back(std::move(error));
}

void GLAPIENTRY on_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length, const GLchar* text,
                           const void* errors) {
  if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) return;
  std::string_view message =
      length < 0 ? std::string_view(text) : std::string_view(text, std::size_t(length));
  while (!message.empty() && message.back() == '\n') message.remove_suffix(1);
  keep_error(*static_cast<std::vector<std::string>*>(const_cast<void*>(errors)), std::string(message));
}

std::string_view error_name(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "invalid enum";
    case GL_INVALID_VALUE:
      return "invalid value";
    case GL_INVALID_OPERATION:
      return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "invalid framebuffer operation";
    case GL_OUT_OF_MEMORY:
      return "out of graphics memory";
    case GL_CONTEXT_LOST:
      return "the graphics card was reset";
    default:
      return "unknown error";
  }
}

}  // namespace

Result<std::unique_ptr<Context>> Context::headless(Debug debug) {
  const char* way_out = "; install libegl1 and libgl1-mesa-dri, or use the CPU renderer";
  if (!epoxy_has_egl()) return fail(ErrorCode::kUnavailable, std::string("no EGL on this machine") + way_out);
  for (const EGLDisplay display : candidate_displays()) {
    if (!Displays::open(display)) continue;
    const EGLContext egl_context = make_current_context(display, debug);
    if (egl_context == EGL_NO_CONTEXT) {
      Displays::close(display);
      continue;
    }
    // make_unique() cannot call the private constructor.
    std::unique_ptr<Context> context(new Context(debug));
    context->display_ = display;
    context->egl_context_ = egl_context;
    return context;
  }
  return fail(ErrorCode::kUnavailable, std::string("no OpenGL 4.5 without a window here") + way_out);
}

Result<std::unique_ptr<Context>> Context::of_current(Debug debug) {
  if (epoxy_gl_version() < 45) {
    return fail(ErrorCode::kUnsupported, "this display's OpenGL is older than 4.5");
  }
  return std::unique_ptr<Context>(new Context(debug));
}

Context::Context(Debug debug) : renderer_name_(text_of(GL_RENDERER)), version_(text_of(GL_VERSION)) {
  if (debug == Debug::kOn) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(on_message, &errors_);
  }
  // Our images have no padding between rows.
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  vertex_array_ = Name<delete_vertex_array>(id);
  glBindVertexArray(id);
}

Context::~Context() {
  assert(is_on_its_thread());
  vertex_array_ = {};
  // The window's context still exists, and its driver must not call back into this object.
  const bool is_current = !egl_context_ || eglGetCurrentContext() == egl_context_;
  if (is_current) glDebugMessageCallback(nullptr, nullptr);
  if (!egl_context_) return;
  if (is_current) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display_, egl_context_);
  Displays::close(display_);
}

bool Context::is_software() const {
  return is_software_renderer(renderer_name_);
}

void Context::barrier(Reader readers) {
  static constexpr std::array<GLbitfield, 7> kBits = {
      GL_TEXTURE_FETCH_BARRIER_BIT,
      GL_SHADER_IMAGE_ACCESS_BARRIER_BIT,
      GL_SHADER_STORAGE_BARRIER_BIT,
      GL_COMMAND_BARRIER_BIT,
      GL_ELEMENT_ARRAY_BARRIER_BIT,
      GL_FRAMEBUFFER_BARRIER_BIT,
      GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_PIXEL_BUFFER_BARRIER_BIT};
  GLbitfield bits = 0;
  for (std::size_t i = 0; i < kBits.size(); ++i) {
    if (unsigned(readers) >> i & 1u) bits |= kBits[i];
  }
  glMemoryBarrier(bits);
}

void Context::flush() {
  glFlush();
}

void Context::finish() {
  glFinish();
}

std::vector<std::string> Context::take_errors() {
  assert(is_on_its_thread());
  // A lost context reports its error forever, so the number of errors is bounded.
  for (std::size_t i = 0; i < kErrorsKept; ++i) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) break;
    // With debug output the driver has already reported this error with a description.
    if (errors_.empty() || !glIsEnabled(GL_DEBUG_OUTPUT)) {
      keep_error(errors_, std::string(error_name(error)));
    }
  }
  return std::exchange(errors_, {});
}

Result<void> Context::check(std::string_view doing) {
  const std::vector<std::string> errors = take_errors();
  if (errors.empty()) return {};
  return fail(ErrorCode::kUnavailable, std::string(doing) + ": " + errors.front());
}

bool has_graphics_card() {
  std::error_code problem;
  if (std::filesystem::exists("/dev/nvidia0", problem)) return true;
  std::filesystem::directory_iterator devices("/dev/dri", problem);
  if (problem) return false;
  return std::any_of(begin(devices), end(devices), [](const std::filesystem::directory_entry& device) {
    return device.path().filename().string().starts_with("renderD");
  });
}

bool is_software_renderer(std::string_view renderer_name) {
  static constexpr std::array<std::string_view, 5> kSigns = {"llvmpipe", "softpipe", "SWR", "swrast",
                                                             "Software"};
  return std::any_of(kSigns.begin(), kSigns.end(), [&](std::string_view sign) {
    return renderer_name.find(sign) != std::string_view::npos;
  });
}

}  // namespace copresence::gl
