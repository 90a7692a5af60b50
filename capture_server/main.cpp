// capture_server: streams one RGB-D camera or recording. See settings.cpp for its command line.
//
// The parent owns the listening socket and waits; the child does all the work, so that a crash in a driver costs a
// sentence or a fresh start and never the port.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <functional>
#include <thread>

#include "capture_server/drivers/simulated/simulated_uri.h"
#include "capture_server/pipeline.h"
#include "capture_server/running_settings.h"
#include "capture_server/sensor/lasting_source.h"
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
  bool any_real = false;
  for (const sensor::DeviceListing& device : *devices) {
    any_real = any_real || !device.source.starts_with("simulated:");
    fmt::print("{}\n  {}{}, driver {}, {}\n", device.source.empty() ? "(cannot be opened)" : device.source,
               device.name, device.serial.empty() ? "" : ", serial " + device.serial, device.driver,
               device.ready ? "ready" : "not ready");
    for (const std::string& mode : device.modes) fmt::print("  {}\n", mode);
    for (const std::string& problem : device.problems) fmt::print("  problem: {}\n", problem);
    if (device.source.starts_with(drivers::kSimulatedPrefix)) {
      fmt::print("  this and others: {}\n", drivers::simulated_cameras());
    }
  }
  if (!any_real) {
    fmt::print("No camera is plugged in. What cameras there are and what they need: docs/cameras.md\n");
  }
  return 0;
}

int stream(RunningSettings& settings, const wire::ListeningSocket& listening, Heartbeat& heartbeat) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("capture_server"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  const bool has_file = !settings.now().config.empty();
  // The child before may have read its file again since.
  if (has_file && heartbeat.replaces_another()) settings.read_again();
  flow::StopOnSignal signals(has_file ? [&settings] { settings.read_again(); } : std::function<void()>());
  std::signal(SIGXFSZ, SIG_IGN);  // a recording that grows beyond a limit is a sentence, not a crash
  while (true) {
    const ServerSettings now = settings.now();
    const auto ran =
        run_pipeline(now, listening, settings.rates(), signals.token(), [&] { heartbeat.beat(); });
    if (ran) return 0;
    // What crashed was a camera being unplugged, perhaps: it was there once, so it is waited for.
    const bool may_come = heartbeat.replaces_another() && (ran.error().code == ErrorCode::kNotFound ||
                                                           ran.error().code == ErrorCode::kUnavailable);
    if (!may_come) return say(ran.error());
    heartbeat.beat();
    std::this_thread::sleep_for(sensor::LastingSource::kBetweenTries);
    if (signals.token().stop_requested()) return 0;
  }
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
  RunningSettings running(argc, argv, *settings);
  return supervise(
      {.subject = settings->source, .passes_hangup = !settings->config.empty(), .restart = !recording},
      [&](Heartbeat& heartbeat) { return stream(running, *listening, heartbeat); });
}
