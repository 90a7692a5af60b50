#include "common/depth/entropy/residual_coder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/depth/entropy/ans_coder.h"
#include "tests/common/depth/scenes.h"

namespace copresence::depth {
namespace {

using testing::kinect_scene;
using testing::Scene;

// An encoder, a decoder, and the last decoded picture.
struct Pair {
  Pair(PixelFormat format, int width, int height)
      : encoder(format, width, height), decoder(format, width, height) {}

  std::size_t carry(const Picture& picture, const StateImage& states, bool complete) {
    std::vector<std::uint8_t> bytes;
    encoder.encode(picture, states, complete, bytes);
    decoder.decode(bytes, states, complete, back);
    return bytes.size();
  }

  ResidualEncoder encoder;
  ResidualDecoder decoder;
  Picture back;
};

int sample(const Picture& picture, std::size_t i) {
  return picture.format() == PixelFormat::kGray10 ? picture.plane10()[i] : picture.plane8(0)[i];
}

void expect_same_where_there_is_depth(const Picture& picture, const Picture& back, const StateImage& states) {
  ASSERT_EQ(back.format(), picture.format());
  ASSERT_EQ(back.width(), picture.width());
  ASSERT_EQ(back.height(), picture.height());
  for (std::size_t i = 0; i < states.pixels().size(); ++i) {
    if (states.data()[i] == DepthState::kHole) continue;
    ASSERT_EQ(sample(back, i), sample(picture, i)) << i;
  }
}

// Depth in steps of 4 mm, a smooth picture with edges.
Picture picture_of(const Scene& scene, PixelFormat format) {
  Picture picture(format, scene.depth.width(), scene.depth.height());
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    const int value = scene.depth.data()[i] / 4;
    if (format == PixelFormat::kGray10) {
      picture.plane10()[i] = static_cast<std::uint16_t>(value % 1024);
    } else {
      picture.plane8(0)[i] = static_cast<std::uint8_t>(value);
    }
  }
  return picture;
}

Picture noise(PixelFormat format, int width, int height, unsigned seed) {
  std::minstd_rand random(seed);
  Picture picture(format, width, height);
  if (format == PixelFormat::kGray10) {
    for (auto& each : picture.plane10()) each = static_cast<std::uint16_t>(random() % 1024);
  } else {
    for (auto& each : picture.plane8(0)) each = static_cast<std::uint8_t>(random() % 256);
  }
  return picture;
}

StateImage random_states(int width, int height, unsigned seed) {
  StateImage states(width, height);
  std::minstd_rand random(seed);
  for (DepthState& state : states.pixels()) state = static_cast<DepthState>(random() % 3);
  return states;
}

class ResidualCoder : public ::testing::TestWithParam<PixelFormat> {};
INSTANTIATE_TEST_SUITE_P(Formats, ResidualCoder, ::testing::Values(PixelFormat::kGray8, PixelFormat::kGray10),
                         [](const auto& param) { return std::string(name(param.param)); });

TEST_P(ResidualCoder, BringsEverySampleBackOnEveryShape) {
  for (const auto& [width, height] :
       {std::pair{2, 2}, {16, 2}, {2, 16}, {18, 6}, {62, 10}, {66, 30}, {320, 240}}) {
    Pair pair(GetParam(), width, height);
    for (int time = 0; time < 4; ++time) {
      const Scene scene = kinect_scene(width, height, time);
      const Picture picture = picture_of(scene, GetParam());
      pair.carry(picture, scene.state, time == 0 || time == 2);
      expect_same_where_there_is_depth(picture, pair.back, scene.state);
      const auto seed = static_cast<unsigned>(time);
      const Picture random = noise(GetParam(), width, height, seed);
      const StateImage states = random_states(width, height, seed);
      pair.carry(random, states, false);
      expect_same_where_there_is_depth(random, pair.back, states);
    }
  }
}

TEST_P(ResidualCoder, SpendsNothingOnHoles) {
  Pair pair(GetParam(), 64, 48);
  const StateImage holes(64, 48, DepthState::kHole);
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_EQ(pair.carry(noise(GetParam(), 64, 48, i), holes, i == 0), 4u * AnsWriter::kStreams);
  }
}

TEST_P(ResidualCoder, CostsNextToNothingWhereNothingChanges) {
  Pair pair(GetParam(), 320, 240);
  Picture flat(GetParam(), 320, 240);
  const StateImage states(320, 240, DepthState::kMeasured);
  for (int i = 0; i < 3; ++i) pair.carry(flat, states, i == 0);
  EXPECT_LT(pair.carry(flat, states, false), 320u * 240 / 8 / 50);
}

TEST_P(ResidualCoder, CostsHardlyMoreThanItsEntropyWhereNothingCanBePredicted) {
  Pair pair(GetParam(), 320, 240);
  const StateImage states(320, 240, DepthState::kMeasured);
  const std::size_t bytes = pair.carry(noise(GetParam(), 320, 240, 1), states, true);
  const double entropy = GetParam() == PixelFormat::kGray10 ? 10 : 8;
  EXPECT_LT(static_cast<double>(bytes) * 8, 320 * 240 * entropy * 1.25);
}

TEST_P(ResidualCoder, MakesSomePictureOfAnyBytes) {
  std::minstd_rand random(7);
  for (int i = 0; i < 50; ++i) {
    std::vector<std::uint8_t> bytes(random() % 400);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    ResidualDecoder decoder(GetParam(), 64, 48);
    Picture picture;
    decoder.decode(bytes, random_states(64, 48, static_cast<unsigned>(i)), i % 2 == 0, picture);
    EXPECT_EQ(picture.width(), 64);
  }
}

TEST(ResidualCoder, HasTheFormatThatIsDocumented) {
  Picture picture(PixelFormat::kGray10, 16, 2);
  for (std::size_t i = 0; i < 32; ++i) picture.plane10()[i] = static_cast<std::uint16_t>(500 + i / 5);
  StateImage states(16, 2, DepthState::kMeasured);
  states(3, 0) = DepthState::kHole;
  ResidualEncoder encoder(PixelFormat::kGray10, 16, 2);
  std::vector<std::uint8_t> bytes;
  encoder.encode(picture, states, true, bytes);
  EXPECT_EQ(bytes,
            (std::vector<std::uint8_t>{0xbb, 0x7f, 0x52, 0x00, 0x05, 0x7c, 0xbe, 0x03, 0x5e, 0xbb, 0x9d,
                                       0xde, 0xe4, 0x3a, 0x79, 0xe2, 0x00, 0x64, 0x99, 0x28, 0xfd, 0x9c}));
  bytes.clear();
  encoder.encode(picture, states, false, bytes);
  EXPECT_EQ(bytes,
            (std::vector<std::uint8_t>{0x5d, 0xbc, 0x26, 0x00, 0xe1, 0xdd, 0x45, 0x00, 0x5c, 0x7b, 0xdc,
                                       0xdf, 0x60, 0xfd, 0xb2, 0xe5, 0x3c, 0x9c, 0x61, 0xe6, 0xaf, 0x63}));
}

TEST(AdaptiveCdf, HoldsEveryPointInTheSlotOfOneSymbolWhateverItLearns) {
  std::minstd_rand random(3);
  AdaptiveCdf model;
  for (int round = 0; round < 300; ++round) {
    std::uint32_t end = 0;
    for (unsigned symbol = 0; symbol < AdaptiveCdf::kSymbols; ++symbol) {
      const AdaptiveCdf::Slot slot = model.slot(symbol);
      ASSERT_EQ(slot.start, end);
      ASSERT_GE(slot.frequency, 1u);
      end += slot.frequency;
      EXPECT_EQ(model.symbol_at(slot.start), symbol);
      EXPECT_EQ(model.symbol_at(end - 1), symbol);
    }
    ASSERT_EQ(end, 1u << AdaptiveCdf::kBits);
    model.learn(round < 100 ? 15u : round < 200 ? 0u : static_cast<unsigned>(random() % 16));
  }
}

TEST(AnsCoder, ReadsWhatItWroteInBothStreams) {
  std::minstd_rand random(5);
  std::vector<std::uint32_t> buffer(20000);
  AnsWriter writer(buffer.data());
  std::vector<unsigned> streams, numbers;
  AdaptiveCdf models[AnsWriter::kStreams];
  for (int i = 0; i < 8000; ++i) {
    const auto stream = static_cast<unsigned>(random() % AnsWriter::kStreams);
    const auto number = static_cast<unsigned>(i % 7 == 0 ? random() % 1024 : random() % 3);
    streams.push_back(stream);
    numbers.push_back(number);
    if (i % 7 == 0) {
      writer.put_bits(stream, number, 10);
    } else {
      writer.put(stream, models[stream].slot(number));
      models[stream].learn(number);
    }
  }
  std::vector<std::uint8_t> bytes;
  writer.finish(bytes);
  for (AdaptiveCdf& model : models) model = {};
  AnsReader reader(bytes);
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const unsigned stream = streams[i];
    if (i % 7 == 0) {
      ASSERT_EQ(reader.get_bits(stream, 10), numbers[i]);
    } else {
      ASSERT_EQ(reader.get(stream, models[stream]), numbers[i]);
      models[stream].learn(numbers[i]);
    }
  }
}

}  // namespace
}  // namespace copresence::depth
