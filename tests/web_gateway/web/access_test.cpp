#include "web_gateway/web/access.h"

#include <gtest/gtest.h>

namespace copresence::web {
namespace {

bool serves(const Access& access, std::string_view host, std::string_view origin = {}) {
  return access.reason_to_refuse(host, origin).empty();
}

TEST(Access, WithoutATokenServesThisMachineByItsLoopbackNamesOnly) {
  const Access access;
  for (const auto* host : {"127.0.0.1:8080", "localhost", "LocalHost:80", "[::1]:8080"})
    EXPECT_TRUE(serves(access, host)) << host;
  for (const auto* host : {"", "attacker.example", "127.0.0.1.attacker.example:8080", "localhost.example",
                           "192.0.2.1:8080", "[::2]:8080", "[::1"})
    EXPECT_FALSE(serves(access, host)) << host;
}

TEST(Access, WithATokenOrOpenServesEveryHostName) {
  EXPECT_TRUE(serves({"0a"}, "room.example"));
  EXPECT_TRUE(serves({"", true}, "room.example"));
}

TEST(Access, RefusesScriptsOfOtherSites) {
  const Access access{"0a"};
  EXPECT_TRUE(serves(access, "room.example:8443", "https://room.example:8443"));
  EXPECT_TRUE(serves(access, "room.example", "http://Room.Example"));
  for (const auto* origin : {"https://other.example", "https://room.example:8444", "null", "room.example",
                             "https://", "https://room.example.other"})
    EXPECT_FALSE(serves(access, "room.example", origin)) << origin;
}

TEST(Access, AdmitsTheWholeTokenOnly) {
  const Access access{"0123456789abcdef"};
  EXPECT_TRUE(access.admits("0123456789abcdef"));
  for (const auto* token : {"", "0", "0123456789abcde", "0123456789abcdee", "0123456789abcdef0",
                            "0123456789abcdef0123456789abcdef"})
    EXPECT_FALSE(access.admits(token)) << token;
}

TEST(Access, WithoutATokenAdmitsEverybody) {
  EXPECT_TRUE(Access{}.admits(""));
  EXPECT_TRUE(Access{}.admits("an old link"));
}

}  // namespace
}  // namespace copresence::web
