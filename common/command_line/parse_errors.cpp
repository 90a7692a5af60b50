#include "common/command_line/parse_errors.h"

#include <fmt/format.h>

#include <cstdio>

#include "common/text/excerpt.h"

namespace copresence::command_line {
namespace {

constexpr std::size_t kMostOfASentence = 1000;

}  // namespace

std::string parse_error_message(const CLI::ParseError& error) {
  std::string text = error.what();
  // CLI11 writes "--scene: 1 required TEXT missing". Users understand "needs a value" better.
  if (error.get_name() == "ArgumentMismatch" && text.ends_with(" missing")) {
    text.resize(std::min(text.find(": "), text.size()));
    text += " needs a value";
  }
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  return text::excerpt(text, kMostOfASentence);
}

int report_parse_error(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);
  std::string program = app.get_name();
  for (const CLI::App* verb : app.get_subcommands()) program += ' ' + verb->get_name();
  fmt::print(stderr, "{}: {}; see --help\n", program, parse_error_message(error));
  return 2;
}

}  // namespace copresence::command_line
