#include "web_gateway/forwarding/page_messages.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace copresence::forwarding {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

TEST(PageMessages, AJoinHasItsTypeAndAToken) {
  EXPECT_EQ(parse_join(R"({"type":"join","token":"0a"})"), "0a");
  EXPECT_EQ(parse_join(R"({"type":"join","token":"","later":1})"), "");
}

TEST(PageMessages, EverythingElseIsNoJoin) {
  for (const std::string text :
       {"", "{", "null", "[]", "\"join\"", R"({"type":"join"})", R"({"token":""})",
        R"({"type":"join","token":1})", R"({"type":"JOIN","token":""})", R"({"type":["join"],"token":""})",
        "{\"type\":\"join\",\"token\":\"\xff\"}"}) {
    EXPECT_FALSE(parse_join(text)) << text;
  }
  EXPECT_FALSE(parse_join(std::string(100'000, '['))) << "nested without end";
}

TEST(PageMessages, ListTheCameras) {
  const std::vector<RoomCamera> cameras = {{"left", "127.0.0.1:7001"}, {"", "[::1]:7002"}};
  const json room = json::parse(room_message(cameras));
  EXPECT_EQ(room["type"], "room");
  EXPECT_TRUE(room["protocol"].is_number());
  ASSERT_EQ(room["cameras"].size(), 2u);
  EXPECT_EQ(room["cameras"][1], (json{{"index", 1}, {"name", ""}, {"address", "[::1]:7002"}}));
}

TEST(PageMessages, HaveTheProtocolsWords) {
  EXPECT_EQ(json::parse(state_message(2, CameraState::kWaiting, "un\"plugged")),
            (json{{"type", "state"}, {"camera", 2}, {"state", "waiting"}, {"text", "un\"plugged"}}));
  EXPECT_EQ(json::parse(clock_message(1, -1500us)),
            (json{{"type", "clock"}, {"camera", 1}, {"offset_us", -1500}}));
  EXPECT_EQ(json::parse(refused_message(Refusal::kToken))["reason"], "token");
  EXPECT_EQ(json::parse(refused_message(Refusal::kFull))["reason"], "full");
}

TEST(PageMessages, AreUtf8WhateverAServerSays) {
  EXPECT_TRUE(json::accept(state_message(0, CameraState::kFailed, "\xff\xfe")));
}

}  // namespace
}  // namespace copresence::forwarding
