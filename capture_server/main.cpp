// capture_server: streams one RGB-D camera or recording. See settings.cpp for the command line.
//
// The parent process owns the listening socket and supervises the child process, which does all the
// work. After a crash in a driver, a new child continues on the same port.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <functional>
#include <optional>

#include "capture_server/capture_thread.h"
#include "capture_server/diagnosis/device_listing.h"
#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/pipeline.h"
#include "capture_server/running_settings.h"
#include "capture_server/sensor/source.h"
#include "capture_server/settings.h"
#include "capture_server/supervisor/supervisor.h"
#include "common/flow/stop_on_signal.h"
#include "common/flow/tune_allocator.h"
#include "common/tls/room_key.h"

namespace copresence::server {
namespace {

int say(const Error& error) {
  fmt::print(stderr, "capture_server: {}\n", error.what);
  return 1;
}

int list_devices() {
  const auto devices = diagnosis::list_devices();
  if (!devices) return say(devices.error());
  bool any_real = false;
  for (const diagnosis::DeviceListing& device : *devices) {
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
    fmt::print("No camera is plugged in. What cameras there are and what they need: docs/guide/cameras.md\n");
  }
  return 0;
}

// Reads the settings file again, because the previous child may have read a changed one. If that
// reading crashed the previous child, the server keeps the settings of its start.
void catch_up(RunningSettings& settings, const Heartbeat& heartbeat) {
  const Predecessor& predecessor = heartbeat.predecessor();
  if (!predecessor.existed || settings.now().config.empty()) return;
  if (predecessor.crashed_while == RunningSettings::kReading) {
    spdlog::warn(
        "{}: reading it again crashed; the server goes on with the settings that it was started with",
        settings.now().config);
    return;
  }
  settings.read_again();
}

/// Returns the room's key, or nothing if none is named.
Result<std::optional<tls::RoomKey>> read_key(const ServerSettings& settings) {
  if (settings.key.empty()) return std::optional<tls::RoomKey>();
  const auto key = tls::read_key(settings.key);
  if (!key) return fail(key.error());
  return std::optional(*key);
}

int stream(RunningSettings& settings, const wire::ListeningSocket& listening, const tls::RoomKey* key,
           Heartbeat& heartbeat) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("capture_server"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  const auto read_again = [&] {
    const auto activity = heartbeat.doing(RunningSettings::kReading, "mend the file of --config");
    settings.read_again();
  };
  {
    const auto activity = heartbeat.doing(RunningSettings::kReading, "mend the file of --config");
    catch_up(settings, heartbeat);
  }
  const bool has_file = !settings.now().config.empty();
  flow::StopOnSignal signals(has_file ? read_again : std::function<void()>());
  // If a recording exceeds the file size limit (ulimit -f), writing fails with an error instead of
  // a signal.
  std::signal(SIGXFSZ, SIG_IGN);
  CaptureThread capture;
  const ServerSettings now = settings.now();
  const auto ran =
      run_pipeline(now, listening, key, settings.encoder_changes(), signals.token(), heartbeat, capture);
  if (signals.token().stop_requested() && (ran || ran.error().code == ErrorCode::kEndOfStream))
    return kEndedBySignal;
  return ran ? 0 : say(ran.error());
}

}  // namespace
}  // namespace copresence::server

int main(int argc, char** argv) {
  using namespace copresence;
  using namespace copresence::server;
  flow::tune_allocator();
  const auto settings = read_command_line(argc, argv);
  if (!settings) return settings.error();
  if (settings->list) return list_devices();
  if (!settings->make_key.empty()) {
    const auto made = tls::make_key(settings->make_key);
    return made ? 0 : say(made.error());
  }
  const auto key = read_key(*settings);
  if (!key) return say(key.error());
  const bool may_be_reached = settings->insecure || *key;
  const auto listening = wire::listen(
      settings->listen, may_be_reached ? wire::Reach::kOtherMachines : wire::Reach::kThisMachine);
  if (!listening) return say(listening.error());
  const bool recording = sensor::is_recording(settings->source);
  RunningSettings running(argc, argv, *settings);
  return supervise(
      {.subject = settings->source, .passes_hangup = !settings->config.empty(), .plays_recording = recording},
      [&](Heartbeat& heartbeat) { return stream(running, *listening, *key ? &**key : nullptr, heartbeat); });
}
