// Compares the bytes in docs/internals/wire_format.md with the bytes of the message codec.

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>

#include "common/wire/flow_control/client_window.h"
#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {
namespace {

// The values that the page states in its text.
static_assert(kProtocolVersion == 7);
static_assert(kMaxMessageBytes == 8 << 20 && kMaxTextBytes == 512 && kMaxNameBytes == 64 &&
              kMaxParameters == 64);
static_assert(ClientWindow::kBytes == 1 << 20);

/// The bytes of a drawing in the page. Its lines are "offset  byte byte ...  description".
struct Drawing {
  Bytes bytes;
  bool offsets_hold = true;
};

std::map<std::string, Drawing> drawings_of(const std::string& path) {
  std::map<std::string, Drawing> drawings;
  std::ifstream page(path);
  const std::regex begins("```hex (.+)"), bytes(" *([0-9]+)  ([0-9a-f]{2}(?: [0-9a-f]{2})*)(?:  .*)?");
  Drawing* open = nullptr;
  std::smatch match;
  for (std::string line; std::getline(page, line);) {
    if (std::regex_match(line, match, begins)) {
      open = &drawings[match[1]];
    } else if (line == "```") {
      open = nullptr;
    } else if (open) {
      if (!std::regex_match(line, match, bytes)) {
        ADD_FAILURE() << "not a line of a drawing: " << line;
        continue;
      }
      open->offsets_hold &= std::stoul(match[1]) == open->bytes.size();
      const std::string hex = match[2];
      for (std::size_t i = 0; i < hex.size(); i += 3) {
        open->bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
      }
    }
  }
  return drawings;
}

TEST(WireFormat, IsWhatItsPageDraws) {
  auto drawings = drawings_of("docs/internals/wire_format.md");
  for (const auto& [name, message] : sample_messages()) {
    ASSERT_TRUE(drawings.contains(name)) << "docs/internals/wire_format.md does not draw " << name;
    EXPECT_EQ(drawings[name].bytes, message) << name;
    EXPECT_TRUE(drawings[name].offsets_hold) << name;
    drawings.erase(name);
  }
  EXPECT_TRUE(drawings.empty()) << "docs/internals/wire_format.md draws " << drawings.begin()->first
                                << ", which nobody says";
}

}  // namespace
}  // namespace copresence::wire
