#include "common/depth/depth_codec.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "common/depth/edge_repair.h"
#include "tests/common/depth/scenes.h"

namespace copresence::depth {
namespace {

using testing::flat_scene;
using ::testing::HasSubstr;
using testing::kinect_scene;
using testing::Scene;

DepthFormat kinect_format(int width = 160, int height = 120) {
  return {width, height, DepthUnit::kMillimetre, {}};
}

// Both ends of a stream without video coding between them.
class Stream {
 public:
  explicit Stream(std::string_view codec, DepthFormat format = kinect_format())
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

// The greatest error in millimetres that each codec promises at depth z, without video coding.
double bound_mm(std::string_view codec, double z) {
  const double inverse_range = 1 / 400.0 - 1 / 5000.0;
  if (codec == "quantized" || codec == "adaptive") return 0;
  if (codec == "accuracy8") return z * z * inverse_range / 510 * 1.02 + 0.5;
  if (codec == "accuracy10") return z * z * inverse_range / 2046 * 1.02 + 0.5;
  if (codec == "triangle" || codec == "direct") return 600.0 / 1020 + 1;
  return 4600.0 / 8191 / 2 + 0.5;  // spiral, away from edges
}

// Where one chroma sample covers two upper parts, spiral in 4:2:0 promises no more than staying among the
// neighbours, and nothing at an edge. How far the neighbours of a pixel lie apart; -1 at an edge.
int spread_mm(const Scene& scene, int x, int y) {
  int spread = 0;
  for (int ny = std::max(0, y - 3); ny < std::min(scene.depth.height(), y + 4); ++ny) {
    for (int nx = std::max(0, x - 3); nx < std::min(scene.depth.width(), x + 4); ++nx) {
      spread = std::max(spread, std::abs(scene.depth(nx, ny) - scene.depth(x, y)));
    }
  }
  return spread > 70 ? -1 : spread;
}

class EveryCodec : public ::testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(Codecs, EveryCodec, ::testing::ValuesIn(codec_names().begin(), codec_names().end()),
                         [](const auto& param) {
                           std::string name(param.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(EveryCodec, BringsDepthBackWithinItsBoundAndStatesExactly) {
  Stream stream(GetParam());
  for (int time = 0; time < 6; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    stream.carry(scene, time == 3);
    ASSERT_EQ(stream.state, scene.state);
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const int z = scene.depth(x, y), back = stream.depth(x, y);
        if (scene.state(x, y) == DepthState::kHole) {
          ASSERT_EQ(back, 0);
        } else if (scene.state(x, y) == DepthState::kMeasured) {
          const bool votes = stream.encoder.description().format == PixelFormat::kYuv420;
          const int spread = votes ? spread_mm(scene, x, y) : 0;
          if (spread < 0) continue;
          ASSERT_LE(std::abs(z - back), std::max<double>(bound_mm(GetParam(), z), spread))
              << z << " mm at " << x << ' ' << y << " frame " << time;
        }
      }
    }
  }
}

TEST_P(EveryCodec, KeepsHolesHolesAndDepthDepthWhateverVideoCodingDoesToThePicture) {
  Stream stream(GetParam());
  stream.encoder.set_lossless(false);
  std::minstd_rand random(1);
  for (int time = 0; time < 3; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    PlanarDepth planes = stream.send(scene);
    for (int plane = 0; plane < planes.picture.planes(); ++plane) {
      if (planes.picture.format() == PixelFormat::kGray10) {
        for (auto& sample : planes.picture.plane10()) sample = static_cast<std::uint16_t>(random() % 65536);
      } else {
        for (auto& sample : planes.picture.plane8(plane)) sample = static_cast<std::uint8_t>(random() % 256);
      }
    }
    ASSERT_TRUE(stream.receive(planes));
    EXPECT_EQ(stream.state, scene.state);
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      const int back = stream.depth.data()[i];
      ASSERT_EQ(back == 0, scene.state.data()[i] == DepthState::kHole);
      ASSERT_TRUE(back == 0 || (back >= 400 && back <= 5000)) << back;
    }
  }
}

TEST_P(EveryCodec, CountsDepthOutsideTheRangeAsHoles) {
  Scene scene = flat_scene(160, 120, 1000);
  const std::array<std::uint16_t, 6> values{1, 399, 400, 5000, 5001, 65535};
  for (std::size_t i = 0; i < values.size(); ++i) scene.depth(static_cast<int>(i) * 16, 60) = values[i];
  scene.depth(159, 119) = 0;  // measured nothing
  Stream stream(GetParam());
  for (int time = 0; time < 2; ++time) {
    stream.carry(scene);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool inside = values[i] >= 400 && values[i] <= 5000;
      EXPECT_EQ(stream.state(static_cast<int>(i) * 16, 60),
                inside ? DepthState::kMeasured : DepthState::kHole);
      EXPECT_EQ(stream.depth(static_cast<int>(i) * 16, 60) != 0, inside);
    }
    EXPECT_EQ(stream.state(159, 119), DepthState::kHole);
  }
}

TEST_P(EveryCodec, TakesImagesOfNothingAndImagesWithoutHoles) {
  Stream stream(GetParam());
  for (const int depth : {0, 1000, 0, 0, 5000, 400}) {
    const Scene scene = flat_scene(160, 120, static_cast<std::uint16_t>(depth));
    stream.carry(scene);
    EXPECT_EQ(stream.state, scene.state);
    EXPECT_EQ(stream.depth(80, 60) == 0, depth == 0);
  }
}

TEST_P(EveryCodec, TakesEveryValueThatSixteenBitsHold) {
  DepthFormat format = kinect_format(256, 256);
  format.range = {0.0001, 6.5535};
  format.unit = DepthUnit::k100Micrometres;
  Scene scene = flat_scene(256, 256, 1);
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    scene.depth.data()[i] = static_cast<std::uint16_t>(i);
    if (i == 0) scene.state.data()[i] = DepthState::kHole;
  }
  Stream stream(GetParam(), format);
  stream.encoder.set_lossless(false);
  stream.carry(scene);
  EXPECT_EQ(stream.state, scene.state);
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i)
    ASSERT_EQ(stream.depth.data()[i] == 0, i == 0);
}

TEST_P(EveryCodec, FindsEveryChangedAndEveryMissingByteOfMaskTableAndSamples) {
  const DepthFormat format = kinect_format(32, 16);
  Stream stream(GetParam(), format);
  const PlanarDepth first = stream.send(kinect_scene(32, 16, 0));
  const PlanarDepth second = stream.send(kinect_scene(32, 16, 9));
  // Damage fails, and so does what follows it, until a keyframe.
  const auto fails = [&](const PlanarDepth& damaged, bool is_second) {
    if (is_second && !stream.receive(first)) return false;
    const auto received = stream.receive(damaged);
    return !received && received.error().code == ErrorCode::kCorrupt && !stream.receive(second);
  };
  for (const PlanarDepth* frame : {&first, &second}) {
    for (auto bytes : {&PlanarDepth::state_mask, &PlanarDepth::table, &PlanarDepth::samples}) {
      const std::size_t size = (frame->*bytes).size();
      for (std::size_t i = 0; i < size; ++i) {
        for (int bit = 0; bit < 8; ++bit) {
          PlanarDepth damaged = *frame;
          (damaged.*bytes)[i] ^= static_cast<std::uint8_t>(1 << bit);
          ASSERT_TRUE(fails(damaged, frame == &second)) << "byte " << i << " bit " << bit;
        }
        PlanarDepth shortened = *frame;
        (shortened.*bytes).resize(i);
        ASSERT_TRUE(fails(shortened, frame == &second)) << "cut at " << i;
      }
      PlanarDepth lengthened = *frame;
      (lengthened.*bytes).push_back(0);
      ASSERT_TRUE(fails(lengthened, frame == &second));
    }
  }
  EXPECT_TRUE(stream.receive(first));
}

TEST_P(EveryCodec, FailsOnLostRepeatedAndReorderedFramesUpToTheNextKeyframe) {
  Stream stream(GetParam());
  std::vector<PlanarDepth> sent;
  for (int time = 0; time < 6; ++time) sent.push_back(stream.send(kinect_scene(160, 120, time), time == 5));
  EXPECT_FALSE(stream.receive(sent[1])) << "begins without a keyframe";
  EXPECT_TRUE(stream.receive(sent[0]));
  EXPECT_FALSE(stream.receive(sent[2])) << "one is lost";
  EXPECT_FALSE(stream.receive(sent[1])) << "only a keyframe helps";
  EXPECT_TRUE(stream.receive(sent[0]));
  EXPECT_TRUE(stream.receive(sent[1]));
  EXPECT_FALSE(stream.receive(sent[1])) << "one comes twice";
  EXPECT_TRUE(stream.receive(sent[5]));
  EXPECT_FALSE(stream.receive(sent[3]));
}

TEST_P(EveryCodec, FailsOnAPictureOfAnotherShapeOrFormat) {
  Stream stream(GetParam());
  stream.encoder.set_lossless(false);
  const Scene scene = kinect_scene(160, 120);
  for (const Picture& wrong :
       {Picture(), Picture(stream.encoder.description().format, 160, 118),
        Picture(stream.encoder.description().format == PixelFormat::kGray8 ? PixelFormat::kGray10
                                                                           : PixelFormat::kGray8,
                160, 120)}) {
    PlanarDepth planes = stream.send(scene, true);
    planes.picture = wrong;
    EXPECT_FALSE(stream.receive(planes));
  }
}

TEST_P(EveryCodec, KeyframesNeedNothingOfEarlierFrames) {
  Stream stream(GetParam());
  for (int time = 0; time < 3; ++time) stream.send(kinect_scene(160, 120, time));
  const Scene scene = kinect_scene(160, 120, 3);
  const PlanarDepth key = stream.send(scene, true);
  EXPECT_TRUE(key.keyframe);
  ASSERT_TRUE(stream.receive(key));
  EXPECT_EQ(stream.state, scene.state);
}

TEST_P(EveryCodec, GoesFromLossToNoneAndBackWithAKeyframe) {
  Stream stream(GetParam());
  const bool gray = stream.send(kinect_scene(160, 120), true).samples.size() > 0;
  for (int time = 0; time < 12; ++time) {
    const bool lossless = time / 3 % 2 == 0;
    stream.encoder.set_lossless(lossless);
    const Scene scene = kinect_scene(160, 120, time);
    const PlanarDepth planes = stream.send(scene);
    EXPECT_EQ(planes.keyframe, time > 0 && time % 3 == 0) << time;
    EXPECT_EQ(planes.samples.empty(), !(lossless && gray)) << time;
    EXPECT_EQ(planes.picture.empty(), !planes.samples.empty());
    if (time < 3) continue;  // the first frame of these builds on one that was not carried
    ASSERT_TRUE(stream.receive(planes)) << time;
    EXPECT_EQ(stream.state, scene.state);
  }
}

TEST_P(EveryCodec, RefusesSamplesWhereThereIsAPictureAndAPictureWhereThereAreSamples) {
  Stream stream(GetParam());
  PlanarDepth planes = stream.send(kinect_scene(160, 120));
  const bool gray = !planes.samples.empty();
  if (gray) {
    std::swap(planes.samples, planes.table);
  } else {
    planes.samples = {1, 2, 3};
  }
  EXPECT_FALSE(stream.receive(planes));
}

TEST(DepthCodec, NamesTheKnownCodecsWhereItDoesNotKnowOne) {
  const auto opened = Encoder::open("h265", kinect_format());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInvalid);
  for (const std::string_view name : codec_names())
    EXPECT_THAT(opened.error().what, HasSubstr(std::string(name)));
  EXPECT_FALSE(Decoder::open({"h265", PixelFormat::kGray8, {}}, kinect_format()));
}

TEST(DepthCodec, TakesAPeriodWhereTheCodecHasOne) {
  const auto opened = Encoder::open("triangle:period=0.8", kinect_format());
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->description().name, "triangle");
  EXPECT_EQ(opened->description().parameters.back(), (std::pair<std::string, double>("period", 800)));
  for (const std::string_view wrong :
       {"triangle:", "triangle:period=", "triangle:period=x", "triangle:period=0.8m", "triangle:period=0.01",
        "triangle:period=9", "triangle:period=nan", "direct:phase=1", "quantized:period=0.8", "quantized:"}) {
    const auto refused = Encoder::open(wrong, kinect_format());
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  }
}

TEST(DepthCodec, RefusesShapesAndRangesThatCannotBe) {
  for (auto spoil : std::initializer_list<void (*)(DepthFormat&)>{
           [](DepthFormat& f) { f.width = 0; }, [](DepthFormat& f) { f.width = 161; },
           [](DepthFormat& f) { f.height = 8192; }, [](DepthFormat& f) { f.unit = DepthUnit{7}; },
           [](DepthFormat& f) {
             f.range = {5, 0.4};
           },
           [](DepthFormat& f) {
             f.range = {0, 1};
           },
           [](DepthFormat& f) {
             f.range = {std::nan(""), 1};
           },
           [](DepthFormat& f) {
             f.range = {70, 80};
           }}) {
    DepthFormat format = kinect_format();
    spoil(format);
    EXPECT_FALSE(Encoder::open("quantized", format));
    EXPECT_FALSE(Decoder::open({"quantized", PixelFormat::kGray10, {}}, format));
  }
}

TEST(DepthCodec, RefusesDescriptionsThatMakeNoSense) {
  for (const std::string_view name : codec_names()) {
    const DepthCodecDescription good = Encoder::open(name, kinect_format())->description();
    ASSERT_TRUE(Decoder::open(good, kinect_format()));
    DepthCodecDescription bad = good;
    bad.format = good.format == PixelFormat::kGray8 ? PixelFormat::kYuv420 : PixelFormat::kGray8;
    EXPECT_FALSE(Decoder::open(bad, kinect_format())) << name;
    for (std::size_t i = 0; i < good.parameters.size(); ++i) {
      for (const double value : {std::nan(""), -1.0, 1e300, std::numeric_limits<double>::infinity()}) {
        bad = good;
        bad.parameters[i].second = value;
        EXPECT_FALSE(Decoder::open(bad, kinect_format()))
            << name << ' ' << good.parameters[i].first << ' ' << value;
      }
      bad = good;
      bad.parameters.erase(bad.parameters.begin() + static_cast<std::ptrdiff_t>(i));
      EXPECT_FALSE(Decoder::open(bad, kinect_format())) << name << " without " << good.parameters[i].first;
    }
  }
}

class CodedByLevels : public ::testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(Codecs, CodedByLevels, ::testing::Values("quantized", "adaptive"),
                         [](const auto& param) { return std::string(param.param); });

TEST_P(CodedByLevels, IsExactWhileLevelsAppearAndFilledPixelsAddNone) {
  Stream stream(GetParam());
  for (int time = 0; time < 8; ++time) {
    Scene scene = kinect_scene(160, 120, time);
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      // Values between the levels, as hole filling makes them.
      if (scene.state.data()[i] == DepthState::kFilled) scene.depth.data()[i] += 3;
    }
    const PlanarDepth planes = stream.send(scene);
    if (time >= 6) {
      EXPECT_LT(planes.table.size(), 40u);
    }
    ASSERT_TRUE(stream.receive(planes));
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      if (scene.state.data()[i] == DepthState::kMeasured) {
        ASSERT_EQ(stream.depth.data()[i], scene.depth.data()[i]);
      } else if (scene.state.data()[i] == DepthState::kFilled) {
        ASSERT_EQ(stream.depth.data()[i], testing::kinect_level(stream.depth.data()[i]));
      }
    }
  }
}

// A ramp over more values than there are codes.
Scene ramp(int width, int height) {
  Scene scene = flat_scene(width, height, 400);
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    const auto column = i % static_cast<std::size_t>(width), row = i / static_cast<std::size_t>(width);
    scene.depth.data()[i] = static_cast<std::uint16_t>(2500 + column + 10 * row);
  }
  return scene;
}

TEST_P(CodedByLevels, RefusesMoreLevelsThanCodesOnlyWhereItMustBeExact) {
  Stream stream(GetParam());
  stream.encoder.set_lossless(true);
  stream.carry(kinect_scene(160, 120));
  const Scene scene = ramp(160, 120);
  const auto refused = stream.encoder.encode(scene.depth, scene.state, false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().what, HasSubstr("1024"));

  stream.encoder.set_lossless(false);
  const PlanarDepth planes = stream.send(scene);
  EXPECT_TRUE(planes.keyframe);
  ASSERT_TRUE(stream.receive(planes));
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    const double z = scene.depth.data()[i];
    ASSERT_NEAR(stream.depth.data()[i], z, bound_mm("accuracy10", z) + 1);
  }
}

std::vector<std::uint16_t> told_levels() {
  std::vector<std::uint16_t> levels;
  for (int z = 400; z <= 5000; ++z) levels.push_back(testing::kinect_level(z));
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

TEST_P(CodedByLevels, LearnsNothingThatTheSensorHasTold) {
  Stream stream(GetParam());
  stream.encoder.set_sensor_levels(told_levels());
  for (int time = 0; time < 6; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    const PlanarDepth planes = stream.send(scene);
    EXPECT_EQ(planes.table.empty(), time > 0);
    ASSERT_TRUE(stream.receive(planes));
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      if (scene.state.data()[i] != DepthState::kMeasured) continue;
      ASSERT_EQ(stream.depth.data()[i], scene.depth.data()[i]);
    }
  }
}

TEST_P(CodedByLevels, IsExactWhereTheSensorHasToldTooManyLevelsOrWrongOnes) {
  for (const int step : {4, 9}) {  // 1150 levels, and 511 that leave no room for those of the scene
    Stream stream(GetParam());
    std::vector<std::uint16_t> told;
    for (int z = 401; z <= 5000; z += step) told.push_back(static_cast<std::uint16_t>(z));
    stream.encoder.set_sensor_levels(told);
    for (int time = 0; time < 4; ++time) {
      Scene scene = flat_scene(160, 120, 400);
      for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i)
        scene.depth.data()[i] =
            static_cast<std::uint16_t>(1000 + (i + 100 * static_cast<std::size_t>(time)) % 900);
      stream.carry(scene);
      ASSERT_EQ(stream.depth, scene.depth);
    }
  }
}

TEST(Adaptive, GivesNoCodeToLevelsThatWereOnlyTold) {
  Stream told("adaptive"), learnt("adaptive");
  told.encoder.set_sensor_levels(told_levels());
  told.encoder.set_lossless(false);
  learnt.encoder.set_lossless(false);
  const Scene scene = kinect_scene(160, 120);
  EXPECT_EQ(told.send(scene).picture, learnt.send(scene).picture);
}

TEST(EdgeRepair, PutsAPixelThatHangsBetweenTwoSurfacesBackOnTheNearerOne) {
  DepthImage depth(16, 8, 1000);
  for (int y = 0; y < 8; ++y) {
    for (int x = 8; x < 16; ++x) depth(x, y) = 2000;
  }
  const DepthImage whole = depth;
  EdgeRepair repair(DepthUnit::kMillimetre);
  repair.repair(depth);
  EXPECT_EQ(depth, whole) << "a clean edge stays";
  for (int y = 0; y < 8; ++y) {
    depth(7, y) = 1100;
    depth(8, y) = 1700;
  }
  repair.repair(depth);
  EXPECT_EQ(depth, whole);
  for (int y = 0; y < 8; ++y) depth(8, y) = 1333;  // half way in steps: either may be right
  const DepthImage unsure = depth;
  repair.repair(depth);
  EXPECT_EQ(depth, unsure);
}

TEST(EdgeRepair, LeavesSlantedSurfacesAlone) {
  DepthImage depth(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) depth(x, y) = static_cast<std::uint16_t>(1500 + 12 * x + 5 * y);
  }
  const DepthImage before = depth;
  EdgeRepair(DepthUnit::kMillimetre).repair(depth);
  EXPECT_EQ(depth, before);
}

TEST(Adaptive, IsQuantizedWhereNothingIsLost) {
  Stream adaptive("adaptive"), quantized("quantized");
  for (int time = 0; time < 4; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    EXPECT_EQ(adaptive.send(scene).samples, quantized.send(scene).samples);
  }
}

TEST(Adaptive, LaysItsTableOutAnewWhereTheSceneHasLeftIt) {
  Stream stream("adaptive");
  stream.encoder.set_lossless(false);
  const auto wall = [](int near, int far, int time) {
    Scene scene = flat_scene(160, 120, 1000);
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      const int z = near + static_cast<int>(i * 7919 + static_cast<std::size_t>(time) * 31) % (far - near);
      scene.depth.data()[i] = testing::kinect_level(z);
    }
    return scene;
  };
  const auto carry = [&](const Scene& scene) {
    const PlanarDepth planes = stream.send(scene);
    EXPECT_TRUE(stream.receive(planes));
    return planes.keyframe;
  };
  int keyframes = 0;
  for (int time = 0; time < 200; ++time) keyframes += carry(wall(2500, 4000, time));
  EXPECT_EQ(keyframes, 1) << "the first";
  for (int time = 0; time < 200; ++time) keyframes += carry(wall(600, 1000, time));
  EXPECT_EQ(keyframes, 2) << "and one after the scene has changed";
}

}  // namespace
}  // namespace copresence::depth
