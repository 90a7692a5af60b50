// Loaded into a program by LD_PRELOAD: appends the allocator's figures to $COPRESENCE_HEAP_PROBE.PID every five seconds, so that
// memory in use can be told from memory that the allocator keeps. Columns: seconds, bytes in use, bytes free in arenas, bytes
// mapped for large blocks.
#define _GNU_SOURCE
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static void* report(void* unused) {
  (void)unused;
  for (int seconds = 0;; seconds += 5) {
    const char* name = getenv("COPRESENCE_HEAP_PROBE");
    char path[4096];
    if (!name || snprintf(path, sizeof(path), "%s.%d", name, getpid()) >= (int)sizeof(path)) return NULL;
    const struct mallinfo2 info = mallinfo2();  // of all arenas
    FILE* file = fopen(path, "a");
    if (file) {
      fprintf(file, "%d %zu %zu %zu\n", seconds, info.uordblks, info.fordblks, info.hblkhd);
      fclose(file);
    }
    const struct timespec pause = {5, 0};
    nanosleep(&pause, NULL);
  }
}

static void start(void) {
  pthread_t thread;
  sigset_t all, before;  // signals are for the program's own threads
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  if (!pthread_create(&thread, NULL, report, NULL)) pthread_detach(thread);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}

__attribute__((constructor)) static void begin(void) {
  pthread_atfork(NULL, NULL, start);  // the server's child does the work
  start();
}
