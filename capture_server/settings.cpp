#include "capture_server/settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <set>
#include <utility>

#include "capture_server/drivers/contract/simulated_uri.h"
#include "capture_server/sensor/source.h"
#include "capture_server/settings_file.h"
#include "common/command_line/parse_errors.h"
#include "common/scene/scene.h"
#include "common/text/excerpt.h"
#include "common/version.h"

namespace copresence::server {
namespace {

constexpr const char* kPurpose =
    "Streams one RGB-D camera, or a recording of one, to render_client over TCP.";

std::string default_name(const ServerSettings& settings) {
  if (sensor::is_recording(settings.source)) return std::filesystem::path(settings.source).stem().string();
  const auto simulated = drivers::parse_simulated_uri(settings.source);
  return simulated ? fmt::format("camera{}", simulated->camera) : "camera";
}

std::string key_of(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

/// Returns a setting's value. A relative path of a file is resolved against `folder`.
std::string from_folder(const std::filesystem::path& folder, const Setting& setting) {
  const bool is_path = setting.key == "scene" || setting.key == "record" || setting.key == "key" ||
                       (setting.key == "source" && sensor::is_recording(setting.value));
  return is_path && !setting.value.empty() ? (folder / setting.value).string() : setting.value;
}

bool is_given(const CLI::Option& option) {
  return option.count() > 0;
}

/// The reason why the server cannot start, and its exit code.
struct Reject {
  std::string what;
  int exit_code = 2;
};

std::string names_of(const scene::Scene& scene) {
  constexpr std::size_t kMost = 10;
  std::vector<std::string> names;
  for (const scene::Camera& camera : scene.cameras) {
    if (names.size() == kMost) return fmt::format("{} and others", fmt::join(names, ", "));
    names.push_back(text::excerpt(camera.name));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The scene file's entry for this server's camera, or nullptr.
tl::expected<const scene::Camera*, Reject> camera_in(const scene::Scene& scene, ServerSettings& settings) {
  if (settings.name.empty() && scene.cameras.size() == 1) settings.name = scene.cameras.front().name;
  if (settings.name.empty() && settings.source.empty()) {
    return tl::unexpected(Reject{
        fmt::format("{} has several cameras: choose one with --name: {}", settings.scene, names_of(scene))});
  }
  const scene::Camera* camera = scene.find(settings.name.empty() ? default_name(settings) : settings.name);
  if (!camera && settings.source.empty()) {
    return tl::unexpected(Reject{fmt::format("{}: no camera is called \"{}\"; its cameras are {}",
                                             settings.scene, text::excerpt(settings.name), names_of(scene)),
                                 1});
  }
  if (settings.source.empty() && camera->source.empty()) {
    return tl::unexpected(Reject{
        fmt::format("{} has no \"source\" for camera \"{}\": give --source", settings.scene, camera->name)});
  }
  return camera;
}

/// Takes source, listening address and key from the scene file, unless they are given elsewhere.
tl::expected<void, Reject> apply_scene(CLI::App& app, ServerSettings& settings) {
  CLI::Option& source = *app.get_option("--source");
  CLI::Option& listen = *app.get_option("--listen");
  CLI::Option& key = *app.get_option("--key");
  const bool needs_no_camera = is_given(source) && is_given(listen);
  if (settings.scene.empty() || (needs_no_camera && (is_given(key) || settings.insecure))) return {};
  const auto scene = scene::load(settings.scene);
  if (!scene) return tl::unexpected(Reject{scene.error().what, 1});
  const auto take = [](CLI::Option& option, const std::string& value) {
    if (is_given(option) || value.empty()) return;
    option.add_result(value);
    option.run_callback();
  };
  if (!settings.insecure) take(key, scene->key);
  if (needs_no_camera) return {};
  const auto camera = camera_in(*scene, settings);
  if (!camera) return tl::unexpected(camera.error());
  if (*camera) {
    take(source, (*camera)->source);
    take(listen, (*camera)->address);
  }
  return {};
}

/// Applies the settings of a file. Flags on the command line, and their opposites, have priority.
/// Fails with a message that starts with FILE:LINE.
Result<void> apply_file(CLI::App& app, const std::filesystem::path& path) {
  const auto settings = load_settings(path);
  if (!settings) return fail(settings.error());
  std::set<const CLI::Option*> on_the_command_line;
  for (const CLI::Option* option : app.get_options()) {
    if (is_given(*option)) on_the_command_line.insert(option);
  }
  for (const Setting& setting : *settings) {
    const auto wrong = [&](const std::string& what) {
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: {}", path.string(), setting.line, what));
    };
    CLI::Option* const option = app.get_option_no_throw("--" + setting.key);
    if (!option || !option->get_configurable()) {
      return wrong(fmt::format("there is no setting \"{}\": see --help, without its dashes",
                               text::excerpt(setting.key)));
    }
    bool is_overruled = on_the_command_line.contains(option);
    for (const CLI::Option* opposite : option->get_excludes()) {
      if (!is_given(*opposite)) continue;
      if (!on_the_command_line.contains(opposite)) {
        return wrong(fmt::format("{} and {} exclude each other", setting.key, key_of(*opposite)));
      }
      is_overruled = true;
    }
    if (is_overruled) continue;
    try {
      const bool is_flag = option->get_expected_min() == 0;
      option->add_result(is_flag ? option->get_flag_value(setting.key, setting.value)
                                 : from_folder(path.parent_path(), setting));
      option->run_callback();
    } catch (const CLI::ParseError& error) {
      return wrong(command_line::parse_error_message(error));
    }
  }
  return {};
}

std::map<std::string, std::string> texts_of(const CLI::App& app) {
  std::map<std::string, std::string> texts;
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_configurable()) continue;
    texts[key_of(*option)] =
        is_given(*option) ? fmt::format("{}", fmt::join(option->results(), " ")) : option->get_default_str();
  }
  return texts;
}

/// Reads all settings. Mistakes give a Reject in files, a CLI::ParseError on the command line.
tl::expected<ServerSettings, Reject> read(CLI::App& app, int argc, const char* const* argv) {
  ServerSettings settings;
  add_flags(app, settings);
  app.parse(argc, argv);
  if (settings.list || !settings.make_key.empty()) return settings;
  if (!settings.config.empty()) {
    if (const auto applied = apply_file(app, settings.config); !applied) {
      return tl::unexpected(Reject{applied.error().what});
    }
  }
  if (auto applied = apply_scene(app, settings); !applied) return tl::unexpected(applied.error());
  if (settings.source.empty()) {
    throw CLI::RequiredError(
        "--source (openni:, openni:URI, simulated:room?camera=N or FILE.oni), or --scene and --name,");
  }
  constexpr std::size_t kMostOfASource = 1024;
  if (settings.source.size() > kMostOfASource) {
    throw CLI::ValidationError(
        "--source", fmt::format("{} has more than {} bytes: give a camera or a file by a shorter name",
                                text::excerpt(settings.source), kMostOfASource));
  }
  if (settings.controls.projector && sensor::is_recording(settings.source)) {
    throw CLI::ValidationError("--projector-slot", "a recording has no projector: leave it out");
  }
  if (settings.start_at && !sensor::is_recording(settings.source)) {
    throw CLI::ValidationError("--start-at", "a camera has no beginning: leave it out");
  }
  if (settings.start_at && settings.pace == sensor::SourceSettings::Pace::kFast) {
    throw CLI::ValidationError(
        "--start-at", "--pace fast sends frames without waiting for a time: leave one of the two out");
  }
  if (settings.name.empty()) settings.name = default_name(settings);
  settings.texts = texts_of(app);
  return settings;
}

}  // namespace

bool ServerSettings::keeps_every_frame() const {
  return pace == sensor::SourceSettings::Pace::kFast && sensor::is_recording(source);
}

tl::expected<ServerSettings, int> read_command_line(int argc, const char* const* argv) {
  CLI::App app{kPurpose, "capture_server"};
  app.set_version_flag("--version", std::string("capture_server ") + kVersion);
  try {
    auto settings = read(app, argc, argv);
    if (settings) return std::move(*settings);
    fmt::print(stderr, "capture_server: {}\n", settings.error().what);
    return tl::unexpected(settings.error().exit_code);
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(command_line::report_parse_error(app, error));
  }
}

Result<ServerSettings> read_again(int argc, const char* const* argv) {
  CLI::App app{kPurpose};
  try {
    auto settings = read(app, argc, argv);
    if (!settings) return fail(ErrorCode::kInvalid, settings.error().what);
    return std::move(*settings);
  } catch (const CLI::ParseError& error) {
    return fail(ErrorCode::kInvalid, command_line::parse_error_message(error));
  }
}

}  // namespace copresence::server
