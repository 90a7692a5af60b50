// Simulates a name server that does not answer, through LD_PRELOAD. getaddrinfo() creates the file
// that SLOW_RESOLVER_ASKED names, and then takes two minutes.

#include <fcntl.h>
#include <netdb.h>
#include <unistd.h>

#include <cstdlib>

extern "C" int getaddrinfo(const char*, const char*, const addrinfo*, addrinfo**) {
  if (const char* path = std::getenv("SLOW_RESOLVER_ASKED")) close(open(path, O_WRONLY | O_CREAT, 0600));
  sleep(120);
  return EAI_AGAIN;
}
