// web_gateway shows the scene that capture_servers stream in browsers. settings.cpp has its command
// line.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "common/flow/stop_on_signal.h"
#include "web_gateway/pipeline.h"
#include "web_gateway/settings.h"
#include "web_gateway/token.h"

namespace {

int exit_code(const copresence::Result<void>& ran) {
  if (ran) return 0;
  fmt::print(stderr, "web_gateway: {}\n", ran.error().what);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace copresence;
  using namespace copresence::gateway;
  const auto settings = read_command_line(argc, argv);
  if (!settings) return settings.error();
  if (!settings->make_token.empty()) return exit_code(make_token(settings->make_token));
  spdlog::set_default_logger(spdlog::stderr_color_mt("web_gateway"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  flow::StopOnSignal signals;
  return exit_code(run_gateway(*settings, signals.source()));
}
