#include "render_client/display/controls.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace copresence::display {
namespace {

using window::Key;

window::KeyEvent press(Key key, window::Modifiers modifiers = {}) {
  return {.key = key, .pressed = true, .repeated = false, .modifiers = modifiers};
}

TEST(Controls, ThePageOfKeysListsTheSameInTheSameOrder) {
  std::ifstream page(testing::recordings() / "../../docs/guide/keys.md");
  ASSERT_TRUE(page);
  std::vector<std::string> rows, expected;
  bool is_viewer = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("## ")) is_viewer = line.starts_with("## The viewer");
    if (is_viewer && line.starts_with("| ") && !line.starts_with("| key")) rows.push_back(line);
  }
  for (const Control& control : controls())
    expected.push_back(std::string("| ") + control.input + " | " + control.effect + " |");
  EXPECT_EQ(rows, expected);
}

TEST(Controls, NoKeyHasTwoCommands) {
  std::set<Key> keys;
  for (const Control& control : controls()) {
    for (const Key key : control.keys) {
      if (key == Key::kUnknown) continue;
      EXPECT_TRUE(keys.insert(key).second) << control.input;
    }
  }
}

TEST(Controls, EveryKeyGivesItsCommandWhenItIsPressed) {
  for (const Control& control : controls()) {
    for (const Key key : control.keys) {
      if (key == Key::kUnknown) continue;
      EXPECT_EQ(command_of(press(key)), control.command) << control.input;
      EXPECT_EQ(command_of({.key = key, .pressed = false, .repeated = false, .modifiers = {}}), std::nullopt);
      EXPECT_EQ(command_of({.key = key, .pressed = true, .repeated = true, .modifiers = {}}), std::nullopt);
      EXPECT_EQ(command_of(press(key, {.shift = false, .control = true, .alt = false})), std::nullopt);
    }
  }
  EXPECT_EQ(command_of(press(Key{'H'})), Command::kListKeys);
  EXPECT_EQ(command_of(press(Key::kUnknown)), std::nullopt);
  EXPECT_EQ(command_of(press(Key{'~'})), std::nullopt);
}

}  // namespace
}  // namespace copresence::display
