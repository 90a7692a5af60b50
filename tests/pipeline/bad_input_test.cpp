// What goes wrong says so in one sentence, and loses nothing.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/pipeline/running_room.h"

namespace copresence::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

struct Ended {
  std::optional<int> code;
  std::string words;
};

Ended run(std::vector<std::string> arguments) {
  arguments[0] = program(arguments[0]);
  Process process(arguments);
  const auto code = process.wait(seconds(10));
  return {code, process.output()};
}

std::string listen_somewhere() {
  return "127.0.0.1:" + std::to_string(free_port());
}

Ended serve(const std::filesystem::path& recording) {
  return run({"capture_server", "--source", recording, "--listen", listen_somewhere(), "--pace", "fast"});
}

long lines(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n');
}

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++found;
  return found;
}

std::string read_all(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void expect_one_sentence(const Ended& ended, int code) {
  EXPECT_EQ(ended.code, code) << ended.words;
  EXPECT_EQ(lines(ended.words), 1) << ended.words;
}

TEST(BadInput, ARecordingThatIsNoneIsRefusedWithOneSentence) {
  TemporaryFolder folder;
  const std::string whole = read_all(recordings() / "camera0.oni");
  ASSERT_GT(whole.size(), 1000u);
  std::ofstream(folder / "empty.oni");
  std::ofstream(folder / "text.oni") << "hello\n";
  std::ofstream(folder / "header.oni") << whole.substr(0, 24);
  std::ofstream(folder / "cut.oni") << whole.substr(0, whole.size() / 2);
  for (const auto& path : {folder / "missing.oni", folder / "empty.oni", folder / "text.oni",
                           folder / "header.oni", folder / "cut.oni", recordings()}) {
    const Ended ended = serve(path);
    expect_one_sentence(ended, 1);
    EXPECT_THAT(ended.words, HasSubstr(path.filename().string()));
  }
}

TEST(BadInput, ADamagedPayloadPlaysToTheEnd) {
  TemporaryFolder folder;
  std::string bytes = read_all(recordings() / "camera0.oni");
  for (std::size_t at = bytes.size() / 3; at < bytes.size() / 3 + 400; at += 100) bytes[at] ^= 0x10;
  std::ofstream(folder / "damaged.oni") << bytes;
  const Ended ended = serve(folder / "damaged.oni");
  EXPECT_EQ(ended.code, 0) << ended.words;
}

/// A recording's bytes with every picture of depth damaged, and nothing else.
std::string without_depth(std::string bytes) {
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  constexpr std::uint32_t kNewData = 0x0A, kSeekTable = 0x0E, kEnd = 0x0B, kDepthNode = 1;
  for (std::size_t at = 24; at + 28 <= bytes.size() && number(at + 4) != kEnd;) {
    const std::uint32_t type = number(at + 4), fields = number(at + 12);
    const std::uint32_t payload = type == kNewData || type == kSeekTable ? number(at + 16) : 0;
    if (type == kNewData && number(at + 8) == kDepthNode) {
      bytes.replace(at + fields, payload, payload, '\xff');
    }
    at += fields + payload;
  }
  return bytes;
}

TEST(BadInput, ARecordingWithoutOneWholePictureOfDepthPlaysToTheEndAndSaysSoOnce) {
  TemporaryFolder folder;
  std::ofstream(folder / "damaged.oni") << without_depth(read_all(recordings() / "camera0.oni"));
  const Ended ended = serve(folder / "damaged.oni");
  EXPECT_EQ(ended.code, 0) << ended.words;
  EXPECT_EQ(count(ended.words, "cannot be decoded"), 1) << ended.words;
  EXPECT_EQ(count(ended.words, "pictures were damaged"), 1) << ended.words;
}

TEST(BadInput, WhoLooksAtADamagedRecordingThatLoopsIsToldAndWaits) {
  RunningRoom room;
  std::ofstream(room.file("damaged.oni")) << without_depth(read_all(recordings() / "camera0.oni"));
  room.serve(room.file("damaged.oni"), {"--loop"});
  ASSERT_TRUE(room.server(0).says("cannot be decoded", seconds(10))) << room.server(0).output();
  Process& client = room.look({"--frames", "5"});
  EXPECT_TRUE(client.says("cannot be decoded", seconds(10))) << client.output();
  EXPECT_EQ(client.wait(milliseconds(300)), std::nullopt) << client.output();
  EXPECT_EQ(room.server(0).wait(milliseconds(1)), std::nullopt) << room.server(0).output();
  EXPECT_EQ(count(room.server(0).output(), "cannot be decoded"), 1) << room.server(0).output();
}

TEST(BadInput, AWrongCommandLineIsExplainedAndExitsWithTwo) {
  const std::string recording = recordings() / "camera0.oni";
  EXPECT_EQ(run({"capture_server"}).code, 2);
  EXPECT_EQ(run({"capture_server", "--source", recording, "--colour"}).code, 2);
  const Ended codec = run({"capture_server", "--source", recording, "--codec", "zip"});
  EXPECT_EQ(codec.code, 2);
  EXPECT_THAT(codec.words, HasSubstr("quantized"));
  const Ended range = run({"capture_server", "--source", recording, "--range", "5:0.4"});
  EXPECT_EQ(range.code, 2);
  EXPECT_THAT(range.words, HasSubstr("below FAR"));
  EXPECT_EQ(run({"capture_server", "--source", recording, "--range", "near:far"}).code, 2);
  EXPECT_EQ(run({"capture_server", "--source", recording, "--depth-qp", "52"}).code, 2);
  EXPECT_EQ(run({"render_client"}).code, 2);
  EXPECT_EQ(run({"render_client", "--connect", "127.0.0.1:1", "--size", "641x360"}).code, 2);
  EXPECT_EQ(run({"render_client", "--connect", "127.0.0.1:1", "--view", "telepathy"}).code, 2);
  for (const char* picture : {"view.jpg", "view.jpeg", "view", "png", ".png.bmp"}) {
    TemporaryFolder folder;
    const Ended ended = run({"render_client", "--connect", "127.0.0.1:1", "--screenshot", folder / picture});
    EXPECT_EQ(ended.code, 2) << picture;
    EXPECT_THAT(ended.words, HasSubstr("must end in .png")) << picture;
    EXPECT_FALSE(std::filesystem::exists(folder / picture)) << picture;
  }
  for (const char* flag : {"--stats", "--screenshot"}) {
    const Ended nowhere = run({"render_client", "--connect", "127.0.0.1:1", flag, "/no/such/folder/file"});
    EXPECT_EQ(nowhere.code, 2) << flag;
    EXPECT_THAT(nowhere.words, HasSubstr("there is no folder /no/such/folder")) << flag;
  }
}

TEST(BadInput, MoreCamerasThanAViewShowsAreRefused) {
  std::vector<std::string> many{"render_client", "--headless"};
  TemporaryFolder folder;
  std::ofstream scene(folder / "scene.toml");
  for (int i = 0; i < 33; ++i) {
    many.insert(many.end(), {"--connect", "127.0.0.1:1"});
    scene << "[[camera]]\nname = \"c" << i << "\"\naddress = \"127.0.0.1:1\"\nwidth = 640\nheight = 480\n"
          << "fx = 585\nfy = 585\ncx = 320\ncy = 240\n";
  }
  scene.close();
  for (const char* renderer : {"cpu", "gl"}) {
    auto arguments = many;
    arguments.insert(arguments.end(), {"--renderer", renderer});
    const Ended ended = run(arguments);
    EXPECT_EQ(ended.code, 2) << ended.words;
    EXPECT_THAT(ended.words, HasSubstr("33 cameras are given; one view shows at most 32"));
    const Ended of_file =
        run({"render_client", "--headless", "--scene", folder / "scene.toml", "--renderer", renderer});
    expect_one_sentence(of_file, 1);
    EXPECT_THAT(of_file.words, HasSubstr("scene.toml: 33 cameras"));
  }
}

TEST(BadInput, HelpAndVersionSucceed) {
  for (const char* name : {"capture_server", "render_client", "simulate_kinect"}) {
    EXPECT_EQ(run({name, "--help"}).code, 0) << name;
    const Ended version = run({name, "--version"});
    EXPECT_EQ(version.code, 0) << name;
    EXPECT_THAT(version.words, HasSubstr("0.")) << name;
  }
}

TEST(BadInput, APortInUseIsNamed) {
  RunningRoom room;
  room.serve(recordings() / "camera0.oni", {"--loop"});
  ASSERT_TRUE(room.server(0).says("camera0", seconds(10)));
  const Ended ended =
      run({"capture_server", "--source", recordings() / "camera1.oni", "--listen", room.address(0)});
  expect_one_sentence(ended, 1);
  EXPECT_THAT(ended.words, HasSubstr(room.address(0)));
}

TEST(BadInput, AnAddressBeyondThisMachineNeedsAKeyOrInsecure) {
  const Ended ended = run({"capture_server", "--source", recordings() / "camera0.oni", "--listen",
                           "0.0.0.0:" + std::to_string(free_port())});
  expect_one_sentence(ended, 1);
  EXPECT_THAT(ended.words, HasSubstr("--key FILE"));
  EXPECT_THAT(ended.words, HasSubstr("--insecure"));
}

TEST(BadInput, AnUnreadablePathFileIsNamed) {
  const Ended missing =
      run({"render_client", "--headless", "--connect", "127.0.0.1:1", "--view", "path:/nowhere.txt"});
  expect_one_sentence(missing, 1);
  EXPECT_THAT(missing.words, HasSubstr("/nowhere.txt"));
  TemporaryFolder folder;
  std::ofstream(folder / "views.txt") << "0 0 0 0 0 0 1\nfive 0 0 0 0 0 1\n";
  const Ended garbled = run({"render_client", "--headless", "--connect", "127.0.0.1:1", "--view",
                             "path:" + (folder / "views.txt").string()});
  expect_one_sentence(garbled, 1);
  EXPECT_THAT(garbled.words, HasSubstr("views.txt:2"));
}

TEST(BadInput, ABadSceneFileIsNamedWithItsLine) {
  TemporaryFolder folder;
  std::ofstream(folder / "scene.toml") << "[[camera]]\nname = \"a\"\nsize = 3\n";
  const Ended ended = run({"render_client", "--headless", "--scene", folder / "scene.toml"});
  expect_one_sentence(ended, 1);
  EXPECT_THAT(ended.words, HasSubstr("scene.toml:"));
}

TEST(BadInput, AWindowWithoutADisplayIsRefusedWithTheWayOut) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const Ended ended = run({"render_client", "--connect", "127.0.0.1:1", "--view", "mouse"});
  expect_one_sentence(ended, 1);
  EXPECT_THAT(ended.words, HasSubstr("--headless"));
  const Ended headless = run({"render_client", "--headless", "--connect", "127.0.0.1:1", "--view", "mouse"});
  EXPECT_EQ(headless.code, 2) << headless.words;
}

int connect_to(const std::string& address) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.find(':') + 1))));
  EXPECT_EQ(connect(socket, reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0);
  return socket;
}

TEST(BadInput, GarbageAndHalfAMessageOnThePortDisturbNobody) {
  RunningRoom room;
  room.serve(recordings() / "camera0.oni", {"--loop"});
  ASSERT_TRUE(room.server(0).says("camera0", seconds(10)));
  const int garbage = connect_to(room.address(0)), half = connect_to(room.address(0)),
            silent = connect_to(room.address(0));
  const std::string noise(100000, '\xff');
  EXPECT_GT(send(garbage, noise.data(), noise.size(), MSG_NOSIGNAL), 0);
  EXPECT_EQ(send(half, "\x01\x00\x00", 3, MSG_NOSIGNAL), 3);
  const auto stats = room.view({"--frames", "20", "--size", "320x180"});
  EXPECT_EQ(stats["cameras"][0]["drops"]["decode_error"], 0);
  for (int socket : {garbage, half, silent}) close(socket);
}

TEST(BadInput, AServerThatIsNotThereIsNamedOnceAndWaitedFor) {
  const std::string address = listen_somewhere();
  Process client({program("render_client"), "--headless", "--connect", address});
  ASSERT_TRUE(client.says("waiting for it", seconds(10))) << client.output();
  EXPECT_EQ(count(client.output(), address), 1) << client.output();
  EXPECT_EQ(client.wait(milliseconds(300)), std::nullopt) << client.output();
}

TEST(BadInput, AnAddressThatIsNoneIsNamedOnce) {
  const Ended ended = run({"render_client", "--headless", "--connect", "kitchen"});
  expect_one_sentence(ended, 1);
  EXPECT_EQ(count(ended.words, "kitchen"), 1) << ended.words;
}

TEST(BadInput, AServerThatTalksSomethingElseIsNoReasonToCrash) {
  const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  bind(listening, reinterpret_cast<sockaddr*>(&address), size);
  getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size);
  listen(listening, 4);
  Process client({program("render_client"), "--headless", "--connect",
                  "127.0.0.1:" + std::to_string(ntohs(address.sin_port))});
  const int accepted = accept(listening, nullptr, nullptr);
  const std::string page = "HTTP/1.0 400 Bad Request\r\n\r\n";
  EXPECT_GT(send(accepted, page.data(), page.size(), MSG_NOSIGNAL), 0);
  close(accepted);
  const int again = accept(listening, nullptr, nullptr);  // it tries once more
  EXPECT_GE(again, 0);
  EXPECT_EQ(client.wait(milliseconds(300)), std::nullopt) << client.output();
  close(again);
  close(listening);
}

}  // namespace
}  // namespace copresence::testing
