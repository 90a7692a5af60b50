// Makes library calls block in programs that load this library with LD_PRELOAD. COPRESENCE_STALLS
// names a folder. While the folder has a file with one of these names, the call does not return:
//
//   disk     Writing to a recording (pwrite).
//   encoder  Encoding a picture (avcodec_send_frame).
//   wire     Waiting for the network in the thread "wire" (epoll_wait).

#include <dlfcn.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/types.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>

struct AVCodecContext;
struct AVFrame;

namespace {

void stall(const char* what) {
  const char* const folder = std::getenv("COPRESENCE_STALLS");
  if (!folder) return;
  const std::string file = std::string(folder) + "/" + what;
  while (::access(file.c_str(), F_OK) == 0) ::usleep(20'000);
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
  static auto* const write = real<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  stall("disk");
  return write(file, bytes, size, offset);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
  static auto* const write = real<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
  stall("disk");
  return write(file, bytes, size, offset);
}

int avcodec_send_frame(AVCodecContext* codec, const AVFrame* frame) {
  static auto* const send = real<int(AVCodecContext*, const AVFrame*)>("avcodec_send_frame");
  stall("encoder");
  return send(codec, frame);
}

int epoll_wait(int epoll, epoll_event* events, int most, int timeout) {
  static auto* const wait = real<int(int, epoll_event*, int, int)>("epoll_wait");
  char name[16] = {};
  ::prctl(PR_GET_NAME, name);
  if (std::strcmp(name, "wire") == 0) stall("wire");
  return wait(epoll, events, most, timeout);
}

}  // extern "C"
