#include "common/wire/listening_socket.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/wire/host_port.h"
#include "common/wire/transport/connection.h"

namespace copresence::wire {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

Error error_of(const std::string& address) {
  const auto socket = listen(address, Reach::kThisMachine);
  return socket ? Error{ErrorCode::kInvalid, "no error"} : socket.error();
}

TEST(HostPort, ReadsWhatPeopleWrite) {
  EXPECT_EQ(*parse_host_port("127.0.0.1:7001"), (HostPort{"127.0.0.1", 7001}));
  EXPECT_EQ(*parse_host_port("kitchen.local:65535"), (HostPort{"kitchen.local", 65535}));
  EXPECT_EQ(*parse_host_port("[::1]:7001"), (HostPort{"::1", 7001}));
}

TEST(HostPort, SaysHowToWriteIt) {
  for (const char* text : {"", ":", "localhost", "localhost:", ":7001", "a:65536", "a:-1", "a:7x", "::1:7001",
                           "[]:7001", "a b\n:7001"}) {
    const auto address = parse_host_port(text);
    ASSERT_FALSE(address) << text;
    EXPECT_EQ(address.error().code, ErrorCode::kInvalid);
    EXPECT_THAT(address.error().what, HasSubstr("write HOST:PORT"));
  }
}

TEST(Connection, CountsAnIpv4AddressOr64BitsOfIpv6AsOneNetwork) {
  const auto network = [](const char* address) { return network_of(asio::ip::make_address(address)); };
  EXPECT_EQ(network("192.168.1.7"), "192.168.1.7");
  EXPECT_EQ(network("::ffff:192.168.1.7"), "192.168.1.7");
  EXPECT_EQ(network("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(network("2001:db8:1:2:ffff::1"), network("2001:db8:1:2::9"));
}

TEST(ListeningSocket, NamesThePortItGot) {
  const auto socket = listen("127.0.0.1:0", Reach::kThisMachine);
  ASSERT_TRUE(socket) << socket.error().what;
  EXPECT_THAT(socket->address(), MatchesRegex("127\\.0\\.0\\.1:[1-9][0-9]+"));
}

TEST(ListeningSocket, SaysThatAPortIsInUse) {
  const auto socket = listen("127.0.0.1:0", Reach::kThisMachine);
  ASSERT_TRUE(socket);
  const Error error = error_of(socket->address());
  EXPECT_EQ(error.code, ErrorCode::kUnavailable);
  EXPECT_THAT(error.what, HasSubstr(socket->address() + " is in use"));
}

TEST(ListeningSocket, StaysOnThisMachineUnlessToldOtherwise) {
  for (const char* address : {"0.0.0.0:0", "[::]:0", "[::ffff:0.0.0.0]:0"}) {
    const Error error = error_of(address);
    if (error.code == ErrorCode::kNotFound) continue;  // no IPv6 here
    EXPECT_EQ(error.code, ErrorCode::kInvalid) << address;
    EXPECT_THAT(error.what, HasSubstr("--key FILE")) << address;
    EXPECT_THAT(error.what, HasSubstr("--insecure")) << address;
  }
  EXPECT_TRUE(listen("0.0.0.0:0", Reach::kOtherMachines));
}

TEST(ListeningSocket, SaysThatAnAddressIsNotOfThisMachine) {
  EXPECT_EQ(listen("203.0.113.7:0", Reach::kOtherMachines).error().code, ErrorCode::kUnavailable);
}

TEST(ListeningSocket, IsTakenOverFromAParent) {
  auto parents = listen("127.0.0.1:0", Reach::kThisMachine);
  ASSERT_TRUE(parents);
  const std::string address = parents->address();
  const auto childs = ListeningSocket::adopt(::dup(parents->descriptor()));
  ASSERT_TRUE(childs);
  EXPECT_EQ(childs->address(), address);
}

TEST(ListeningSocket, TakesNothingElseOver) {
  EXPECT_FALSE(ListeningSocket::adopt(-1));
  const int file = ::open("/dev/null", O_RDONLY);
  EXPECT_FALSE(ListeningSocket::adopt(file));
  ::close(file);
}

}  // namespace
}  // namespace copresence::wire
