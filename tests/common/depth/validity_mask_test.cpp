#include "common/depth/mask/validity_mask.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/common/depth/scenes.h"

namespace copresence::depth {
namespace {

using testing::kinect_scene;

// An encoder, a decoder, and the last decoded states.
struct Pair {
  explicit Pair(int width, int height) : encoder(width, height), decoder(width, height) {}

  std::size_t carry(const StateImage& states, bool complete) {
    std::vector<std::uint8_t> bytes;
    encoder.encode(states, complete, bytes);
    decoder.decode(bytes, complete, back);
    return bytes.size();
  }

  ValidityMaskEncoder encoder;
  ValidityMaskDecoder decoder;
  StateImage back;
};

StateImage random_states(int width, int height, unsigned seed) {
  StateImage states(width, height);
  std::minstd_rand random(seed);
  for (DepthState& state : states.pixels()) state = static_cast<DepthState>(random() % 3);
  return states;
}

TEST(ValidityMask, BringsEveryStateBackOnEveryShape) {
  for (const auto& [width, height] :
       {std::pair{2, 2}, {16, 2}, {18, 6}, {62, 10}, {64, 4}, {66, 30}, {640, 480}}) {
    Pair pair(width, height);
    for (int time = 0; time < 4; ++time) {
      const StateImage scene = kinect_scene(width, height, time).state;
      pair.carry(scene, time == 0 || time == 2);
      EXPECT_EQ(pair.back, scene) << width << 'x' << height << " at " << time;
      const StateImage noise = random_states(width, height, static_cast<unsigned>(time));
      pair.carry(noise, false);
      EXPECT_EQ(pair.back, noise) << width << 'x' << height << " at " << time;
    }
  }
}

TEST(ValidityMask, CostsNextToNothingWhereNothingChanges) {
  Pair pair(640, 480);
  const StateImage scene = kinect_scene(640, 480).state;
  const std::size_t first = pair.carry(scene, true);
  std::size_t last = 0;
  for (int i = 0; i < 20; ++i) last = pair.carry(scene, false);
  EXPECT_LT(last, first / 3);
  for (const DepthState state : {DepthState::kMeasured, DepthState::kHole, DepthState::kFilled}) {
    for (int i = 0; i < 2; ++i) EXPECT_LT(pair.carry(StateImage(640, 480, state), i == 0), 700u);
    EXPECT_LT(pair.carry(StateImage(640, 480, state), false), 60u);
  }
}

TEST(ValidityMask, CostsHardlyMoreThanItsEntropyWhereNothingCanBePredicted) {
  Pair pair(640, 480);
  std::size_t bytes = 0;
  for (unsigned i = 0; i < 4; ++i) bytes += pair.carry(random_states(640, 480, i + 1), i == 0);
  const double bits_per_pixel = static_cast<double>(bytes) * 8 / (4 * 640 * 480);
  EXPECT_LT(bits_per_pixel, std::log2(3.0) * 1.15);
}

TEST(ValidityMask, MakesSomeMaskOfAnyBytes) {
  std::minstd_rand random(7);
  for (int i = 0; i < 50; ++i) {
    std::vector<std::uint8_t> bytes(random() % 400);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    ValidityMaskDecoder decoder(64, 48);
    StateImage states;
    decoder.decode(bytes, i % 2 == 0, states);
    ASSERT_EQ(states.pixels().size(), 64u * 48u);
    for (const DepthState state : states.pixels()) ASSERT_LE(static_cast<int>(state), 2);
  }
}

TEST(ValidityMask, HasTheFormatThatIsDocumented) {
  StateImage states(64, 6, DepthState::kMeasured);
  for (int x = 5; x < 20; ++x) states(x, 2) = DepthState::kHole;
  for (int x = 9; x < 12; ++x) states(x, 2) = DepthState::kFilled;
  ValidityMaskEncoder encoder(64, 6);
  std::vector<std::uint8_t> bytes;
  encoder.encode(states, true, bytes);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0x77, 0xff, 0x82, 0xe3, 0xf0, 0x16, 0x44, 0xb1, 0x47}));
  states(6, 2) = DepthState::kMeasured;
  bytes.clear();
  encoder.encode(states, false, bytes);
  EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0x00, 0x00, 0x00, 0x9b, 0xf8, 0x32, 0x2b, 0x74}));
}

}  // namespace
}  // namespace copresence::depth
