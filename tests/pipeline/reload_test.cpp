// A running server reads its settings again: real processes, SIGHUP, and what then comes over the wire.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "capture_server/recording/oni_writer.h"
#include "common/depth/depth_codec.h"
#include "common/video/frame_decoder.h"
#include "common/wire/frame_client.h"
#include "tests/pipeline/running_room.h"

namespace copresence::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

constexpr int kFramesASecond = 30;

/// Connected all the time; takes and decodes what comes.
class Viewer {
 public:
  explicit Viewer(const std::string& address)
      : client_(connected(address)),
        video_(video::FrameDecoder::open(client_.description()).value()),
        depth_(depth::Decoder::open(client_.description().codec, format(client_.description())).value()) {}

  /// Bytes of depth of each of the next frames.
  std::vector<double> watch(int frames) {
    std::vector<double> sizes;
    while (static_cast<int>(sizes.size()) < frames) {
      const auto received = client_.receive({});
      if (!received) {
        ADD_FAILURE() << received.error().what;
        break;
      }
      const auto planes = video_.decode(received->frame);
      EXPECT_TRUE(planes && depth_.decode(planes->depth, image_, states_))
          << "frame " << received->frame.sequence;
      keyframes_ += received->frame.keyframe ? 1 : 0;
      sizes.push_back(static_cast<double>(received->frame.depth.size()));
    }
    return sizes;
  }

  int keyframes() const { return keyframes_; }

 private:
  static depth::DepthFormat format(const StreamDescription& stream) {
    return {stream.model.width, stream.model.height, stream.unit, stream.range, stream.noise};
  }

  static wire::FrameClient connected(const std::string& address) {
    for (int tries = 0; tries < 100; ++tries) {
      auto client = wire::FrameClient::connect(address, seconds(2), {});
      if (client) return std::move(*client);
      std::this_thread::sleep_for(milliseconds(100));
    }
    throw std::runtime_error("no server at " + address);
  }

  wire::FrameClient client_;
  video::FrameDecoder video_;
  depth::Decoder depth_;
  DepthImage image_;
  StateImage states_;
  int keyframes_ = 0;
};

double kbps(std::vector<double>::const_iterator first, std::vector<double>::const_iterator last) {
  const double bytes = std::accumulate(first, last, 0.0);
  return bytes * 8 / 1000 * kFramesASecond / static_cast<double>(last - first);
}

double mean_kbps(const std::vector<double>& sizes) {
  return kbps(sizes.begin(), sizes.end());
}

/// The most that any 30 frames in a row take.
double worst_second_kbps(const std::vector<double>& sizes) {
  double worst = 0;
  for (auto first = sizes.begin(); first + kFramesASecond <= sizes.end(); ++first) {
    worst = std::max(worst, kbps(first, first + kFramesASecond));
  }
  return worst;
}

/// Sends SIGHUP and goes on watching, lest the viewer fall behind, until the server has said something.
void hang_up(const Process& server, Viewer& viewer, const std::string& then_says) {
  server.signal(SIGHUP);
  for (int frame = 0; frame < 150; ++frame) {
    viewer.watch(1);
    if (server.says(then_says, milliseconds(0))) return;
  }
  ADD_FAILURE() << "\"" << then_says << "\" is not in what the server says:\n" << server.output();
}

class Reload : public ::testing::Test {
 protected:
  Reload() {
    write("depth-kbps = 4000\n");
    room_.serve(recordings() / "camera0.oni", {"--loop", "--config", file_});
  }

  /// quantized: adaptive makes keyframes of its own.
  void write(const std::string& rates, const std::string& codec = "quantized") const {
    std::ofstream(file_) << "codec = \"" << codec << "\"\n" << rates;
  }

  RunningRoom room_;
  std::string file_ = room_.file("camera.toml");
};

TEST_F(Reload, GivesDepthAnotherRateWhileViewersStay) {
  Viewer viewer(room_.address(0));
  viewer.watch(kFramesASecond);
  const int keyframes_at_first = viewer.keyframes();
  EXPECT_NEAR(mean_kbps(viewer.watch(2 * kFramesASecond)), 4000, 400);

  write("depth-kbps = 1500\n");
  hang_up(room_.server(0), viewer, "depth-kbps 4000 -> 1500");
  viewer.watch(10);  // on their way
  const auto after = viewer.watch(4 * kFramesASecond);
  EXPECT_NEAR(mean_kbps(after), 1500, 150);
  EXPECT_LE(worst_second_kbps(after), 1.1 * 1500);
  EXPECT_EQ(viewer.keyframes(), keyframes_at_first);
}

TEST_F(Reload, GoesOnAsBeforeWhereTheFileIsWrong) {
  Viewer viewer(room_.address(0));
  viewer.watch(kFramesASecond);
  write("depth-kbps = 1500\nspeed = 3\n");
  hang_up(room_.server(0), viewer,
          "camera.toml:3: there is no setting \"speed\": see --help, without its dashes; everything goes on");
  EXPECT_NEAR(mean_kbps(viewer.watch(2 * kFramesASecond)), 4000, 400);
  std::filesystem::remove(file_);
  hang_up(room_.server(0), viewer, "a settings file was expected there; everything goes on as before");
  EXPECT_NEAR(mean_kbps(viewer.watch(2 * kFramesASecond)), 4000, 400);
}

TEST_F(Reload, GoesFromARateToAQuantiserToNoLossAndBackWithAKeyframeEach) {
  Viewer viewer(room_.address(0));
  viewer.watch(5);
  for (const char* depth : {"depth-qp = 30", "depth-qp = 0", "depth-qp = 24", "depth-kbps = 2000"}) {
    const int keyframes_before = viewer.keyframes();
    write(std::string(depth) + "\n");
    hang_up(room_.server(0), viewer, std::string("-> ") + (std::strchr(depth, '=') + 2));
    viewer.watch(kFramesASecond);
    EXPECT_EQ(viewer.keyframes(), keyframes_before + 1) << depth;
  }
  EXPECT_LE(worst_second_kbps(viewer.watch(2 * kFramesASecond)), 1.1 * 2000);
}

TEST_F(Reload, NamesWhatTakesARestart) {
  Viewer viewer(room_.address(0));
  write("depth-kbps = 4000\n", "accuracy10");
  hang_up(room_.server(0), viewer, "a restart of the server is needed for codec quantized -> accuracy10");
  viewer.watch(10);
  room_.server(0).signal(SIGTERM);
  EXPECT_EQ(room_.server(0).wait(seconds(1)), 0) << room_.server(0).output();
}

TEST(ReloadOfAFineSensor, LeavesNoLossAgainWhereItTurnsOutImpossible) {
  TemporaryFolder folder;
  const std::string file = folder / "fine.toml", recording = folder / "fine.oni";
  recording::OniContent content;
  content.camera.model = {64, 48, 58, 58, 31.5, 23.5, {}};
  content.color = std::nullopt;
  auto writer = recording::OniWriter::create(recording, content);
  ASSERT_TRUE(writer) << writer.error().what;
  DepthImage depth(64, 48);
  for (int frame = 0; frame < 30; ++frame) {
    for (int i = 0; i < 64 * 48; ++i)
      depth.data()[i] = static_cast<std::uint16_t>(500 + i + frame);  // > 1024 levels
    ASSERT_TRUE(writer->write_depth(milliseconds(33 * (frame + 1)), depth));
  }
  ASSERT_TRUE(writer->finish());

  std::ofstream(file) << "depth-qp = 20\n";
  RunningRoom room;
  room.serve(recording, {"--loop", "--config", file});
  Viewer viewer(room.address(0));
  viewer.watch(10);
  std::ofstream(file) << "depth-qp = 0\n";
  hang_up(room.server(0), viewer,
          "too many for lossless depth: choose a --depth-qp above 0, or a smaller --range; depth goes on at "
          "qp 20");
  viewer.watch(20);
}

}  // namespace
}  // namespace copresence::testing
