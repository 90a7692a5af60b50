// render_client shows the scene that capture_servers stream. settings.cpp has its command line.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>

#include "common/flow/stop_on_signal.h"
#include "common/flow/tune_allocator.h"
#include "render_client/pipeline.h"
#include "render_client/settings.h"

int main(int argc, char** argv) {
  using namespace copresence;
  using namespace copresence::client;
  flow::tune_allocator();
  const auto settings = read_command_line(argc, argv);
  if (!settings) return settings.error();
  spdlog::set_default_logger(spdlog::stderr_color_mt("render_client"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  // If a file exceeds the file size limit (ulimit -f), writing fails instead of ending the program.
  std::signal(SIGXFSZ, SIG_IGN);
  flow::StopOnSignal signals;
  if (auto ran = run_pipeline(*settings, signals.source()); !ran) {
    fmt::print(stderr, "render_client: {}\n", ran.error().what);
    return 1;
  }
  return 0;
}
