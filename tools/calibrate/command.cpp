#include "tools/calibrate/command.h"

#include <fmt/format.h>
#include <filesystem>

#include "common/command_line/values.h"
#include "common/scene/scene.h"
#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

bool is_file(const std::string& file) {
  std::error_code ignored;
  return !file.empty() && std::filesystem::is_regular_file(file, ignored);
}

CLI::Validator dictionary_name() {
  return {[](std::string& text) {
            if (const auto name = canonical_dictionary(text)) {
              text = *name;
              return std::string();
            }
            return command_line::one_of(marker_dictionaries())(text);
          },
          ""};
}

}  // namespace

CLI::Option* add_overwrite(CLI::App& parser, bool& overwrite) {
  return parser.add_flag("--overwrite", overwrite, "replace output files that exist");
}

Result<void> refuse_existing(std::initializer_list<std::string> files, bool overwrite) {
  for (const std::string& file : files) {
    if (overwrite || !is_file(file)) continue;
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: exists already and is kept; give another name or --overwrite", file));
  }
  return {};
}

Result<void> refuse_other_than_scene(const std::string& file, bool overwrite) {
  if (overwrite || !is_file(file)) return {};
  if (const auto scene = scene::load(file); !scene) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "{}: exists already, is no scene file ({}), and is kept; give another name or --overwrite", file,
            scene.error().what));
  }
  return {};
}

void add_dictionary(CLI::App& parser, std::string& dictionary, int& border_bits, const std::string& help) {
  parser.add_option("--dictionary", dictionary, help)->transform(dictionary_name())->capture_default_str();
  parser
      .add_option("--border-bits", border_bits,
                  "width of the markers' black border in cells; 2 for Kalibr's AprilTag boards")
      ->check(command_line::whole_number(1, 2))
      ->capture_default_str();
}

}  // namespace copresence::calibrate
