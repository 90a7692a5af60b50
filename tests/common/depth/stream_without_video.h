#pragma once

// An encoder and a decoder of a depth codec, for tests.

#include <gtest/gtest.h>

#include <string_view>
#include <utility>

#include "common/depth/depth_codec.h"
#include "tests/common/depth/scenes.h"

namespace copresence::depth::testing {

inline DepthFormat kinect_format(int width = 160, int height = 120) {
  return {width, height, DepthUnit::kMillimetre, {}};
}

// Encoder and decoder of a stream without video coding between them.
class StreamWithoutVideo {
 public:
  explicit StreamWithoutVideo(std::string_view codec, DepthFormat format = kinect_format())
      : encoder(*Encoder::open(codec, format)), decoder(*Decoder::open(encoder.description(), format)) {
    encoder.set_lossless(true);
  }

  PlanarDepth send(const Scene& scene, bool keyframe = false) {
    auto planes = encoder.encode(scene.depth, scene.state, keyframe);
    EXPECT_TRUE(planes) << planes.error().what;
    return *std::move(planes);
  }
  Result<void> receive(const PlanarDepth& planes) { return decoder.decode(planes, depth, state); }
  void carry(const Scene& scene, bool keyframe = false) {
    const auto received = receive(send(scene, keyframe));
    ASSERT_TRUE(received) << received.error().what;
  }

  Encoder encoder;
  Decoder decoder;
  DepthImage depth;
  StateImage state;
};

}  // namespace copresence::depth::testing
