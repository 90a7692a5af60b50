#include "web/native/exports.h"

#include <cassert>
#include <vector>

namespace copresence::web {
namespace {

std::vector<std::uint8_t>& input_memory() {
  static std::vector<std::uint8_t> memory;
  return memory;
}

std::string& result() {
  static std::string text;
  return text;
}

}  // namespace

std::span<const std::uint8_t> input(std::uint32_t bytes) {
  assert(bytes <= input_memory().size());
  return std::span<const std::uint8_t>(input_memory()).first(bytes);
}

int succeed(const JsonObject& object) {
  result() = object.text();
  return 1;
}

int succeed(std::span<const std::uint8_t> bytes) {
  result().assign(bytes.begin(), bytes.end());
  return 1;
}

int fail_with(const Error& error) {
  result() = error.what;
  return 0;
}

COPRESENCE_EXPORT(reserve_input) std::uint8_t* reserve_input(std::uint32_t bytes) {
  if (input_memory().size() < bytes) input_memory().resize(bytes);
  return input_memory().data();
}
COPRESENCE_EXPORT(result_at) const char* result_at() {
  return result().data();
}
COPRESENCE_EXPORT(result_bytes) std::uint32_t result_bytes() {
  return static_cast<std::uint32_t>(result().size());
}

}  // namespace copresence::web
