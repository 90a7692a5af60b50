// capture_server: streams one RGB-D camera or recording. See settings.cpp for its command line.
//
// The parent owns the listening socket and waits; the child does all the work, so that a crash in a driver costs a
// sentence or a fresh start and never the port.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>

#include "capture_server/pipeline.h"
#include "capture_server/settings.h"
#include "capture_server/source.h"
#include "capture_server/supervisor.h"
#include "common/flow/keep_memory.h"
#include "common/flow/stop_on_signal.h"

namespace copresence::server {
namespace {

int say(const Error& error) {
  fmt::print(stderr, "capture_server: {}\n", error.what);
  return 1;
}

int list_devices() {
  const auto devices = sensor::list_devices();
  if (!devices) return say(devices.error());
  for (const sensor::DeviceListing& device : *devices) {
    fmt::print("openni:{}  {} {}  {}\n", device.uri, device.vendor, device.name,
               device.problem.empty() ? "ready" : device.problem);
  }
  if (devices->empty()) {
    fmt::print("No camera found. A Kinect v1 needs a driver that Debian does not ship; see the README.\n");
  }
  return 0;
}

int stream(const ServerSettings& settings, const wire::ListeningSocket& listening, Heartbeat& heartbeat) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("capture_server"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  flow::StopOnSignal signals;
  std::signal(SIGXFSZ, SIG_IGN);  // a recording that grows beyond a limit is a sentence, not a crash
  const auto ran = run_pipeline(settings, listening, signals.token(), [&] { heartbeat.beat(); });
  return ran ? 0 : say(ran.error());
}

}  // namespace
}  // namespace copresence::server

int main(int argc, char** argv) {
  using namespace copresence;
  using namespace copresence::server;
  flow::keep_memory_for_frames();
  const auto settings = read_command_line(argc, argv);
  if (!settings) return settings.error();
  if (settings->list) return list_devices();
  const auto listening = wire::listen(settings->listen, settings->insecure);
  if (!listening) return say(listening.error());
  const bool recording = is_recording(settings->source);
  return supervise({.subject = settings->source, .restart = !recording},
                   [&](Heartbeat& heartbeat) { return stream(*settings, *listening, heartbeat); });
}
